// The files that `extract` writes of imagery, read by OpenImageIO.
#include "builder/export/texture_file.h"

#include <cstdlib>

#include <OpenImageIO/imageio.h>
#include <catch2/catch.hpp>

#include "builder/texture_encode/texture_encode.h"
#include "format/block_texture.h"
#include "tests/support/test_data.h"
#include "tests/support/test_image.h"

namespace cairn {
namespace {

constexpr int kSize = 256;

// A chain of pictures, each its own, so that a mip in another's place shows.
TextureTile texture_of(TextureFormat format) {
  TextureTile tile{format, kSize, {}};
  unsigned seed = 1;
  for (int side = kSize; side > 0; side /= 2) {
    auto image = test::landscape(side, side, 4, seed++);
    for (std::size_t i = 3; format != TextureFormat::bc1 && i < image.rgba.size(); i += 4)
      image.rgba[i] = static_cast<std::uint8_t>(i % 251);
    encode_texture(format, TextureQuality::fast, image.rgba, side, side, tile.texels);
  }
  return tile;
}

}  // namespace

TEST_CASE("OpenImageIO opens an extracted DDS of each format, and every mip holds the decoder's texels") {
  const TextureFormat format = GENERATE(TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7);
  CAPTURE(static_cast<int>(format));
  const test::TempDir folder;
  const auto path = folder.path() / "tile.dds";
  const TextureTile tile = texture_of(format);
  REQUIRE(write_texture_dds(path, tile).ok());

  auto input = OIIO::ImageInput::open(path.string());
  REQUIRE(input);
  std::size_t at = 0;
  int mip = 0;
  for (int side = kSize; side > 0; side /= 2, ++mip) {
    CAPTURE(mip);
    REQUIRE(input->seek_subimage(0, mip));
    const OIIO::ImageSpec spec = input->spec();
    REQUIRE(spec.width == side);
    REQUIRE(spec.height == side);
    REQUIRE(spec.nchannels == 4);
    const auto texels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    std::vector<std::uint8_t> theirs(4 * texels), ours(4 * texels);
    REQUIRE(input->read_image(0, mip, 0, 4, OIIO::TypeDesc::UINT8, theirs.data()));
    const std::size_t bytes = texture_image_bytes(format, side);
    REQUIRE(decode_texture(format, std::span(tile.texels).subspan(at, bytes), side, side, ours).ok());
    at += bytes;
    int furthest = 0;
    for (std::size_t i = 0; i < ours.size(); ++i)
      furthest = std::max(furthest, std::abs(ours[i] - theirs[i]));
    // BC7 is exact; its BC1 and BC3 round otherwise (texture_oracle_test).
    CHECK(furthest <= (format == TextureFormat::bc7 ? 0 : 2));
  }
  CHECK(at == tile.texels.size());
  CHECK_FALSE(input->seek_subimage(0, mip));
}

TEST_CASE("an extracted PNG holds the finest mip's texels") {
  const test::TempDir folder;
  const auto path = folder.path() / "tile.png";
  const TextureTile tile = texture_of(TextureFormat::bc3);
  REQUIRE(write_texture_png(path, tile).ok());
  OIIO::ImageSpec straight;
  straight.attribute("oiio:UnassociatedAlpha", 1);
  auto input = OIIO::ImageInput::open(path.string(), &straight);
  REQUIRE(input);
  std::vector<std::uint8_t> theirs(4 * kSize * kSize), ours(4 * kSize * kSize);
  REQUIRE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, theirs.data()));
  const std::size_t bytes = texture_image_bytes(tile.format, kSize);
  REQUIRE(decode_texture(tile.format, std::span(tile.texels).first(bytes), kSize, kSize, ours).ok());
  CHECK(ours == theirs);
}

}  // namespace cairn
