#include "format/tile_number.h"

#include <bit>
#include <cassert>

namespace cairn {
namespace {

constexpr unsigned kNumberBits = 59;

/// Bit i of the value becomes bit 2i.
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 16) & 0x0000FFFF0000FFFF;
  v = (v | v << 8) & 0x00FF00FF00FF00FF;
  v = (v | v << 4) & 0x0F0F0F0F0F0F0F0F;
  v = (v | v << 2) & 0x3333333333333333;
  return (v | v << 1) & 0x5555555555555555;
}

/// The inverse of spread(): odd bits are dropped.
std::uint64_t gather(std::uint64_t v) {
  v &= 0x5555555555555555;
  v = (v | v >> 1) & 0x3333333333333333;
  v = (v | v >> 2) & 0x0F0F0F0F0F0F0F0F;
  v = (v | v >> 4) & 0x00FF00FF00FF00FF;
  v = (v | v >> 8) & 0x0000FFFF0000FFFF;
  return (v | v >> 16) & 0x00000000FFFFFFFF;
}

/// How many numbers the levels above have: 1 + 4 + 16 + …
std::uint64_t first_of(int level) {
  return ((std::uint64_t{1} << 2 * (level - kMinLevel)) - 1) / 3;
}

}  // namespace

std::uint64_t z_curve(std::uint64_t x, std::uint64_t y) {
  return spread(x) | spread(y) << 1;
}

std::uint64_t tile_number(const TileId& id) {
  assert(is_valid(id));
  return first_of(id.level) + z_curve(static_cast<std::uint32_t>(id.x), static_cast<std::uint32_t>(id.y));
}

std::optional<TileId> tile_of_number(std::uint64_t number) {
  if (number >> kNumberBits != 0) return std::nullopt;
  // The numbers of level l begin at (4^(l + 9) - 1) / 3.
  const int level = kMinLevel + (static_cast<int>(std::bit_width(3 * number + 1)) - 1) / 2;
  if (level > kMaxLevel) return std::nullopt;
  const std::uint64_t place = number - first_of(level);
  const TileId id{level, static_cast<std::int32_t>(gather(place)),
                  static_cast<std::int32_t>(gather(place >> 1))};
  return is_valid(id) ? std::optional(id) : std::nullopt;
}

std::optional<LayerTile> tile_of_key(std::uint64_t key) {
  const std::uint64_t layer = key >> kNumberBits;
  const auto id = tile_of_number(key & ((std::uint64_t{1} << kNumberBits) - 1));
  if (layer >= kLayers || !id) return std::nullopt;
  return LayerTile{static_cast<Layer>(layer), *id};
}

}  // namespace cairn
