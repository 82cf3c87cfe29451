#include "runtime/surface/normal_map.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "cairn/geodesy.h"
#include "runtime/surface/bc5.h"

namespace cairn {
namespace {

/// The values of one channel of one block, as ARB_texture_compression_rgtc says to read it.
std::array<double, 16> read_channel(const std::byte* block) {
  const auto byte = [&](int i) { return static_cast<std::uint64_t>(block[i]); };
  const double first = static_cast<std::int8_t>(byte(0)), second = static_cast<std::int8_t>(byte(1));
  std::uint64_t codes = 0;
  for (int i = 0; i < 6; ++i) codes |= byte(2 + i) << (8 * i);
  std::array<double, 16> values{};
  for (std::size_t i = 0; i < 16; ++i) {
    const auto code = static_cast<int>(codes >> (3 * i) & 7);
    if (code == 0) {
      values[i] = first;
    } else if (code == 1) {
      values[i] = second;
    } else if (first > second) {
      values[i] = ((8 - code) * first + (code - 1) * second) / 7;
    } else {
      values[i] = code == 6 ? -127 : code == 7 ? 127 : ((6 - code) * first + (code - 1) * second) / 5;
    }
  }
  return values;
}

}  // namespace

TEST_CASE("a BC5 value is off by a fourteenth of its block's range at most") {
  std::mt19937 random(3);
  for (const int spread : {0, 1, 2, 9, 60, 254}) {
    std::vector<SignedPair> texels(16);
    for (SignedPair& t : texels) {
      t.x = static_cast<std::int8_t>(-127 + static_cast<int>(random() % static_cast<unsigned>(spread + 1)));
      t.y = static_cast<std::int8_t>(127 - static_cast<int>(random() % static_cast<unsigned>(spread + 1)));
    }
    std::vector<std::byte> block;
    append_bc5(texels, 4, block);
    REQUIRE(block.size() == 16);
    const auto x = read_channel(block.data()), y = read_channel(block.data() + 8);
    for (std::size_t i = 0; i < 16; ++i) {
      CHECK(std::abs(x[i] - texels[i].x) <= spread / 14.0 + 1e-9);
      CHECK(std::abs(y[i] - texels[i].y) <= spread / 14.0 + 1e-9);
    }
  }
}

TEST_CASE("the normals of an inclined plane are the plane's, at every mip") {
  const TileId id = tile_at({0.5, 0.5}, 0);
  const double cell = 3.14159265358979 / 180 * Ellipsoid().semi_major_m / 256;
  HeightTile tile{257, {}, {}};
  for (int r = 0; r < 257; ++r) {
    for (int c = 0; c < 257; ++c) {  // 30 % up to the east, 10 % down to the north, in centimetres
      tile.samples.push_back(static_cast<std::int32_t>(std::lround(100 * cell * (0.3 * c - 0.1 * r))));
    }
  }
  const std::vector<std::byte> blocks = normal_map(id, tile, 0.01, {});
  std::size_t size = 256, offset = 0;
  const double length = std::sqrt(1 + 0.09 + 0.01);
  for (int mip = 0; mip < kNormalMips; ++mip, size /= 2) {
    for (std::size_t at = 0; at < size * size; at += 16) {
      CHECK(read_channel(&blocks[offset + at])[5] / 127 == Approx(-0.3 / length).margin(0.01));
      CHECK(read_channel(&blocks[offset + at + 8])[5] / 127 == Approx(0.1 / length).margin(0.01));
    }
    offset += size * size;
  }
  CHECK(offset == blocks.size());
}

}  // namespace cairn
