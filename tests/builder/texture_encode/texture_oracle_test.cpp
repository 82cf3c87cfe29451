// OpenImageIO's own decoders against cairn's, on random blocks wrapped as DDS files.

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <catch2/catch.hpp>

#include "format/block_texture.h"
#include "format/bytes.h"
#include "tests/support/test_data.h"

namespace cairn {

namespace {

// "Programming Guide for DDS", Microsoft.
std::vector<std::byte> dds_header(TextureFormat format, std::uint32_t size) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  const char* four_cc = format == TextureFormat::bc1   ? "DXT1"
                        : format == TextureFormat::bc3 ? "DXT5"
                                                       : "DX10";
  writer.append(std::as_bytes(std::span("DDS ", 4)));
  const auto bytes =
      static_cast<std::uint32_t>(texture_bytes(format, static_cast<int>(size), static_cast<int>(size)));
  for (const std::uint32_t word : {124U, 0x81007U, size, size, bytes, 0U, 1U}) writer.write(word);
  for (int i = 0; i < 11; ++i) writer.write(0U);
  for (const std::uint32_t word : {32U, 4U}) writer.write(word);
  writer.append(std::as_bytes(std::span(four_cc, 4)));
  for (const std::uint32_t word : {0U, 0U, 0U, 0U, 0U, 0x1000U, 0U, 0U, 0U, 0U}) writer.write(word);
  if (format == TextureFormat::bc7) {
    for (const std::uint32_t word : {98U, 3U, 0U, 1U, 0U}) writer.write(word);
  }
  return header;
}

std::vector<std::uint8_t> read_with_oiio(const std::filesystem::path& path) {
  auto input = OIIO::ImageInput::open(path.string());
  REQUIRE(input);
  const OIIO::ImageSpec spec = input->spec();
  REQUIRE(spec.nchannels == 4);
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(spec.width * spec.height) * 4);
  REQUIRE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, rgba.data()));
  return rgba;
}

}  // namespace

TEST_CASE("OpenImageIO decodes the same texels: BC7 exactly, BC1 and BC3 but for rounding") {
  constexpr int kSize = 256;
  const test::TempDir folder;
  std::mt19937 random(20);
  for (const TextureFormat format : {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7}) {
    std::vector<std::byte> blocks(texture_bytes(format, kSize, kSize));
    for (std::byte& byte : blocks) byte = static_cast<std::byte>(random() & 255);
    for (std::size_t i = 0; format == TextureFormat::bc7 && i < blocks.size(); i += 16) {
      blocks[i] = static_cast<std::byte>((static_cast<unsigned>(blocks[i]) | 1U) << (i / 16 % 8));
    }
    const auto header = dds_header(format, kSize);
    const auto path = folder.path() / ("bc" + std::to_string(static_cast<int>(format)) + ".dds");
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(header.data()), static_cast<std::streamsize>(header.size()));
    file.write(reinterpret_cast<const char*>(blocks.data()), static_cast<std::streamsize>(blocks.size()));
    file.close();

    const auto theirs = read_with_oiio(path);
    std::vector<std::uint8_t> ours(theirs.size());
    REQUIRE(decode_texture(format, blocks, kSize, kSize, ours).ok());
    int furthest = 0;
    std::size_t different = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const int off = std::abs(ours[i] - theirs[i]);
      furthest = std::max(furthest, off);
      different += off > 0;
    }
    CAPTURE(static_cast<int>(format), different);
    // It widens 5 bits as x·255/31, and blends before it rounds; cairn repeats the top bits, as GPUs do.
    CHECK(furthest <= (format == TextureFormat::bc7 ? 0 : 2));
  }
}

}  // namespace cairn
