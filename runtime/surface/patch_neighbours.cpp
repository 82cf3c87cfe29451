#include "runtime/surface/patch_neighbours.h"

#include <bit>

namespace cairn {
namespace {

std::size_t hash_of(const TileId& id) {
  const auto x = static_cast<std::uint64_t>(static_cast<std::uint32_t>(id.x));
  const auto y = static_cast<std::uint64_t>(static_cast<std::uint32_t>(id.y));
  const std::uint64_t mixed =
      (x << 32 | y) * 0x9E3779B97F4A7C15u + static_cast<std::uint64_t>(id.level) * 0xBF58476D1CE4E5B9u;
  return static_cast<std::size_t>(mixed ^ mixed >> 29);
}

}  // namespace

PatchIndex::PatchIndex(std::span<const SurfacePatch> patches)
    : slots_(std::bit_ceil(patches.size() * 4 + 64)), mask_(slots_.size() - 1) {
  for (std::size_t i = 0; i < patches.size(); ++i) {
    Slot& slot = slot_of(patches[i].area);
    slot = {patches[i].area, static_cast<std::uint32_t>(i)};
    for (TileId id = patches[i].area; id.level > kMinLevel;) {
      id = parent_of(id);
      Slot& above = slot_of(id);
      if (above.id == id) break;
      above = {id, kSplit};
    }
  }
}

PatchIndex::Slot& PatchIndex::slot_of(const TileId& id) {
  std::size_t i = hash_of(id) & mask_;
  while (slots_[i].id.level >= kMinLevel && slots_[i].id != id) i = (i + 1) & mask_;
  return slots_[i];
}

const PatchIndex::Slot& PatchIndex::slot_of(const TileId& id) const {
  std::size_t i = hash_of(id) & mask_;
  while (slots_[i].id.level >= kMinLevel && slots_[i].id != id) i = (i + 1) & mask_;
  return slots_[i];
}

std::optional<std::size_t> PatchIndex::covering(TileId id) const {
  for (;;) {
    const Slot& slot = slot_of(id);
    if (slot.id == id) return slot.patch == kSplit ? std::nullopt : std::optional<std::size_t>(slot.patch);
    if (id.level == kMinLevel) return std::nullopt;
    id = parent_of(id);
  }
}

std::optional<TileId> beyond(const TileId& id, Side side) {
  const std::int32_t dx = side == Side::east ? 1 : side == Side::west ? -1 : 0;
  const std::int32_t dy = side == Side::north ? 1 : side == Side::south ? -1 : 0;
  const TileId other = neighbour_of(id, dx, dy);
  return is_valid(other) ? std::optional(other) : std::nullopt;
}

std::vector<SharedSegment> shared_segments(std::span<const SurfacePatch> patches) {
  const PatchIndex index(patches);
  std::vector<SharedSegment> segments;
  segments.reserve(patches.size() * 2);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const TileId& area = patches[i].area;
    for (const Side side : kSides) {
      const auto tile = beyond(area, side);
      const auto other = tile ? index.covering(*tile) : std::nullopt;
      if (!other) continue;
      // Of two of one level, the one to the south or west writes the segment down.
      const bool equal = patches[*other].area.level == area.level;
      if (equal && (side == Side::south || side == Side::west)) continue;
      const std::int64_t first = begin_of(area, side);
      segments.push_back({i, side, *other, first, first + lattice_width(area.level)});
    }
  }
  return segments;
}

}  // namespace cairn
