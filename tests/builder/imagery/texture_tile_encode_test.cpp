// A tile's blocks taken over from its children's.
#include "builder/imagery/texture_tile_encode.h"

#include <array>
#include <cstring>

#include <catch2/catch.hpp>

#include "tests/support/test_image.h"

namespace cairn {
namespace {

constexpr int kSize = 256;

// An image of `side` texels from the middle of which the tiles are cut.
LinearImage landscape(int side, unsigned seed) {
  const test::TestImage picture = test::landscape(side, side, 6, seed);
  LinearImage image = LinearImage::unset(side, side);
  for (int r = 0; r < side; ++r)
    for (int c = 0; c < side; ++c)
      for (int k = 0; k < 4; ++k)
        image.row(r)[c][static_cast<std::size_t>(k)] = static_cast<std::uint16_t>(
            k == 3 ? 65535 : 257 * picture.rgba[static_cast<std::size_t>(4 * (r * side + c) + k)]);
  return image;
}

struct Baked {
  LinearImage image, half;
  EdgeTexels rim;
  EncodedMips mips;
};

// Child q of the tile in the middle of an image of two children and a rim a side.
Baked child_of(const LinearImage& world, int q) {
  const int rim = EdgeTexels::kRim, side = kSize + 2 * rim;
  const int east = q & 1 ? kSize : 0, south = q & 2 ? 0 : kSize;
  Baked child;
  child.image = LinearImage::unset(side, side);
  for (int r = 0; r < side; ++r) std::copy_n(world.row(south + r) + east, side, child.image.row(r));
  child.half = halved(child.image);
  child.rim = EdgeTexels::cut(child.image, child.half);
  child.image.drop_margin(rim);
  child.half.drop_margin(rim / 2);
  return child;
}

Baked parent_of(const std::array<Baked, 4>& children) {
  Baked parent;
  parent.image = LinearImage::unset(kSize, kSize);
  std::array<const EdgeTexels*, 4> rims{};
  for (int q = 0; q < 4; ++q) {
    const LinearImage& half = children[static_cast<std::size_t>(q)].half;
    rims[static_cast<std::size_t>(q)] = &children[static_cast<std::size_t>(q)].rim;
    for (int r = 0; r < kSize / 2; ++r)
      std::copy_n(half.row(r), kSize / 2,
                  parent.image.row((q & 2 ? 0 : kSize / 2) + r) + (q & 1) * (kSize / 2));
  }
  parent.half = halved(parent.image);
  parent.rim = EdgeTexels::join(rims, kSize);
  return parent;
}

TileBlock encode(Baked& tile, const std::array<EncodedMips, 4>& children, TextureQuality quality) {
  ImageryOptions options;
  options.quality = quality;
  LinearImage image = tile.image;
  return encode_texture_tile({3, 1, 2}, {std::move(image), tile.half, tile.rim}, options, children,
                             tile.mips);
}

}  // namespace

TEST_CASE("a tile made of its children's blocks has the bytes and the PSNR that it has without them") {
  const auto quality = GENERATE(TextureQuality::fast, TextureQuality::normal, TextureQuality::best);
  const bool flat = GENERATE(false, true);
  LinearImage world = landscape(2 * kSize + 2 * EdgeTexels::kRim, 7);
  if (flat) {
    // Its halves are of one colour, itself it is not.
    for (int r = 0; r < world.rows; ++r)
      for (int c = 0; c < world.columns; ++c)
        world.row(r)[c] = (r + c) % 2 ? LinearTexel{60000, 60000, 60000, 65535} : LinearTexel{0, 0, 0, 65535};
  }
  std::array<Baked, 4> children;
  std::array<EncodedMips, 4> mips;
  for (int q = 0; q < 4; ++q) {
    const auto i = static_cast<std::size_t>(q);
    children[i] = child_of(world, q);
    encode(children[i], {}, quality);
    mips[i] = children[i].mips;
    REQUIRE(mips[i].size() == 8);
  }
  Baked with = parent_of(children), without = parent_of(children);
  const TileBlock joined = encode(with, mips, quality), plain = encode(without, {}, quality);
  CHECK(joined.block == plain.block);
  CHECK(joined.entry.flags == plain.entry.flags);
  CHECK(joined.entry.min_quanta == plain.entry.min_quanta);
  CHECK(joined.entry.max_quanta == plain.entry.max_quanta);
  CHECK(((plain.entry.flags & kConstant) != 0) == flat);
  REQUIRE(with.mips.size() == without.mips.size());
  for (std::size_t m = 0; m < with.mips.size(); ++m) {
    CHECK(with.mips[m].blocks == without.mips[m].blocks);
    CHECK(with.mips[m].errors == without.mips[m].errors);
  }
}

}  // namespace cairn
