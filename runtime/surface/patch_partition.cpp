#include "runtime/surface/patch_partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn::gl {
namespace {

constexpr double kLargestRadius = 6420000;  // of curvature, terrain included
constexpr double kHighest_m = 9000;         // of walls around what has no heights
constexpr double kNegligible_m = 0.002;     // of deviation, from wherever it is seen

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

double nearest_to_equator(const GeoBounds& bounds) {
  return bounds.south > 0 ? bounds.south : bounds.north < 0 ? bounds.north : 0;
}

/// R(δφ²+δλ²cos²φ)/8, the error of linear interpolation, of a single cell as large as the area.
double chord_deviation_m(const TileId& area) {
  const double cosine = std::cos(glm::radians(nearest_to_equator(tile_bounds(area))));
  const double side = std::ldexp(glm::radians(1.0), -area.level);
  return kLargestRadius * side * side * (1 + cosine * cosine) / 8;
}

/// What encloses a part of an area: a sphere is enough, as the parts are small where it matters.
struct Sphere {
  glm::dvec3 centre;
  double radius = 0;
};
Sphere sphere_around(const TileId& area, const Relief* relief) {
  const GeoBounds b = tile_bounds(area);
  const double low = relief ? static_cast<double>(relief->low_m) : 0;
  const double high = relief ? static_cast<double>(relief->high_m) : kHighest_m;
  const glm::dvec3 centre =
      to_geocentric({(b.west + b.east) / 2, std::min((b.south + b.north) / 2, 90.0)}, (low + high) / 2);
  // The way along the surface from the middle to a corner is no shorter than the chord.
  const double half = glm::radians(b.width()) / 2 * kLargestRadius;
  const double half_east = half * std::cos(glm::radians(nearest_to_equator(b)));
  return {centre, std::hypot(half_east, half) + (high - low) / 2};
}

bool is_seen(const Sphere& sphere, const MeshRules& rules) {
  return std::all_of(rules.inward.begin(), rules.inward.end(), [&](const glm::dvec3& normal) {
    return glm::dot(sphere.centre - rules.eye, normal) + sphere.radius >= 0;
  });
}

/// Null where the patch has no heights.
const Relief* relief_of(const Patch& patch, const TileId& part) {
  return patch.surface.tile ? &patch.surface.tile->relief_under(part) : nullptr;
}

/// Adds the children of a patch that can be seen.
template <class Add>
void for_each_part(const Patch& patch, const MeshRules& rules, Add add) {
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(patch.area, quadrant);
    if (!is_valid(child)) continue;
    const Sphere sphere = sphere_around(child, relief_of(patch, child));
    if (!is_seen(sphere, rules)) continue;
    const double distance = std::max(0.0, glm::length(rules.eye - sphere.centre) - sphere.radius);
    add(Patch{child, patch.from, patch.surface, std::max(distance, patch.distance_m), patch.moves});
  }
}

void add_split(const Patch& patch, const MeshRules& rules, std::vector<Patch>& out) {
  if (cells_log2_for_eye(patch, rules) <= kBlockCellsLog2 || patch.area.level == kMaxLevel) {
    out.push_back(patch);
    return;
  }
  for_each_part(patch, rules, [&](const Patch& part) { add_split(part, rules, out); });
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

int cells_log2_for_eye(const Patch& patch, const MeshRules& rules) {
  const int finest = cells_log2_of(rules.tile_size);
  const double tolerance_px = patch.moves ? rules.tolerance_px / 2 : rules.tolerance_px;
  const double allowed_m = std::max(tolerance_px * patch.distance_m / rules.pixels_per_radian, kNegligible_m);
  const Relief* relief = relief_of(patch, patch.area);
  double deviation = chord_deviation_m(patch.area);
  for (int cells_log2 = 0; cells_log2 < finest; ++cells_log2, deviation /= 4) {
    if (!relief && deviation <= allowed_m) return cells_log2;
    if (!relief) continue;
    const int dropped = patch.surface.tile->id.level + finest - patch.area.level - cells_log2;
    const auto k = static_cast<std::size_t>(std::clamp(dropped, 0, kMaxCellsLog2));
    if (deviation + static_cast<double>(relief->errors[k]) <= allowed_m) return cells_log2;
  }
  return finest;
}

std::vector<Patch> partition_areas(std::span<const MeshArea> areas, const MeshRules& rules) {
  std::vector<Patch> patches;
  patches.reserve(areas.size());
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const MeshArea& area = areas[i];
    add_split({area.area, i, ShownSurface::of(area.surface, area.detail), area.distance_m, area.moves}, rules,
              patches);
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
      for_each_part(patches[i], rules, [&](const Patch& part) { finer.push_back(part); });
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
