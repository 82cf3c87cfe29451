#include "runtime/gl/patch_partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "runtime/bounding_volume.h"

namespace cairn::gl {
namespace {

constexpr double kLargestRadius = 6400000;  // of curvature, terrain included

/// Patches by area: what covers a tile, if that is a patch of its level or a coarser one.
class PatchIndex {
 public:
  explicit PatchIndex(std::span<const Patch> patches) {
    by_area_.reserve(patches.size() * 2);
    for (std::size_t i = 0; i < patches.size(); ++i) by_area_.emplace(patches[i].area, i);
    coarsest_ = kMaxLevel;
    for (const Patch& patch : patches) coarsest_ = std::min(coarsest_, patch.area.level);
  }
  std::optional<std::size_t> covering(TileId id) const {
    for (;;) {
      if (const auto it = by_area_.find(id); it != by_area_.end()) return it->second;
      if (id.level <= coarsest_) return std::nullopt;
      id = parent_of(id);
    }
  }

 private:
  std::unordered_map<TileId, std::size_t> by_area_;
  int coarsest_ = kMinLevel;
};

constexpr std::array kSides{Side::south, Side::north, Side::west, Side::east};

std::optional<TileId> across(const TileId& id, Side side) {
  const std::int32_t dx = side == Side::east ? 1 : side == Side::west ? -1 : 0;
  const std::int32_t dy = side == Side::north ? 1 : side == Side::south ? -1 : 0;
  const TileId other = neighbour_of(id, dx, dy);
  return is_valid(other) ? std::optional(other) : std::nullopt;
}

Patch make_patch(const TileId& area, std::size_t from, const SurfaceTile* surface, const MeshRules& rules) {
  const double low = surface ? surface->low_m : 0, high = surface ? surface->high_m : 0;
  static const Occluder unused(0);
  const BoundingVolume volume = bounding_volume(tile_bounds(area), low, high, unused);
  return {area, from, surface, volume.distance_m(rules.eye)};
}

void add_split(const Patch& patch, const MeshRules& rules, std::vector<Patch>& out) {
  const double chord = chord_deviation_m(patch.area, cells_log2_of(rules.tile_size));
  if (chord * rules.pixels_per_radian <= rules.tolerance_px * patch.distance_m ||
      chord < kNegligibleChord_m || patch.area.level == kMaxLevel) {
    out.push_back(patch);
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(patch.area, quadrant);
    if (is_valid(child)) add_split(make_patch(child, patch.from, patch.surface, rules), rules, out);
  }
}

/// The patches that a neighbour is too fine for.
std::vector<bool> too_coarse(std::span<const Patch> patches) {
  const PatchIndex index(patches);
  std::vector<bool> coarse(patches.size());
  for (const Patch& patch : patches) {
    for (Side side : kSides) {
      const auto tile = across(patch.area, side);
      const auto other = tile ? index.covering(*tile) : std::nullopt;
      if (other && patch.area.level - patches[*other].area.level > kMaxLevelStep) coarse[*other] = true;
    }
  }
  return coarse;
}

}  // namespace

Side SharedSegment::coarser_side() const {
  switch (finer_side) {
    case Side::south:
      return Side::north;
    case Side::north:
      return Side::south;
    case Side::west:
      return Side::east;
    default:
      return Side::west;
  }
}

double chord_deviation_m(const TileId& area, int cells_log2) {
  const GeoBounds bounds = tile_bounds(area);
  const double degree = std::numbers::pi / 180;
  const double nearest_equator = bounds.south > 0 ? bounds.south : bounds.north < 0 ? bounds.north : 0;
  const double cosine = std::cos(nearest_equator * degree);
  const double step = std::ldexp(degree, -area.level - cells_log2);
  return kLargestRadius * step * step * (1 + cosine * cosine) / 8;
}

std::vector<Patch> partition_areas(std::span<const MeshArea> areas, const MeshRules& rules) {
  std::vector<Patch> patches;
  patches.reserve(areas.size());
  for (std::size_t i = 0; i < areas.size(); ++i) {
    add_split({areas[i].area, i, areas[i].surface, areas[i].distance_m}, rules, patches);
  }
  for (;;) {
    const std::vector<bool> split = too_coarse(patches);
    if (std::find(split.begin(), split.end(), true) == split.end()) return patches;
    std::vector<Patch> finer;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      if (!split[i]) {
        finer.push_back(patches[i]);
        continue;
      }
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        const TileId child = child_of(patches[i].area, quadrant);
        if (is_valid(child)) finer.push_back(make_patch(child, patches[i].from, patches[i].surface, rules));
      }
    }
    patches = std::move(finer);
  }
}

std::vector<SharedSegment> shared_segments(std::span<const Patch> patches) {
  const PatchIndex index(patches);
  std::vector<SharedSegment> segments;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const TileId& area = patches[i].area;
    for (Side side : kSides) {
      const auto tile = across(area, side);
      const auto other = tile ? index.covering(*tile) : std::nullopt;
      if (!other) continue;
      // Of two of one level, the one to the south or west writes the segment down.
      const bool equal = patches[*other].area.level == area.level;
      if (equal && (side == Side::south || side == Side::west)) continue;
      const LatticePoint corner = south_west_of(area);
      const bool vertical = side == Side::west || side == Side::east;
      const std::int64_t first = vertical ? corner.y : corner.x;
      const std::int64_t end = vertical ? kLatticePoleToPole : kLatticeAround;
      segments.push_back({i, side, *other, first, std::min(first + lattice_width(area.level), end)});
    }
  }
  return segments;
}

}  // namespace cairn::gl
