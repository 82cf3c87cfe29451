#include "runtime/surface/patch_partition.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "runtime/surface/area_sphere.h"
#include "runtime/surface/patch_neighbours.h"
#include "runtime/surface/vertex_errors.h"

namespace cairn {
namespace {

constexpr double kHighest_m = 9000;        // of walls around what has no heights
constexpr double kNegligible_m = 0.002;    // of errors, from wherever they are seen
constexpr double kSagittaShare = 1.0 / 8;  // of what is allowed
constexpr double kSmall =
    1.0 / 8;  // a patch's radius as a share of its depth, where one tolerance suits all of it

constexpr int kMostForcedNear = 2;  // log2 of cells that curvature asks for at the nearest place

bool overhangs(const TileId& id) {
  const LatticePoint corner = south_west_of(id);
  const std::int64_t width = lattice_width(id.level);
  return corner.x + width > kLatticeAround || corner.y + width > kLatticePoleToPole;
}

/// Splits one area into patches.
class Splitter {
 public:
  Splitter(const SurfaceArea& area, std::size_t from, const ScreenErrorBudget& budget,
           const SurfaceRules& rules, std::vector<SurfacePatch>& out)
      : area_(area),
        from_(from),
        budget_(budget),
        cull_(rules.cull),
        eye_(camera_frame(rules.view).position),
        ellipsoid_(rules.view.ellipsoid),
        surface_(ShownSurface::of(area.surface, area.detail)),
        out_(out) {}

  void add(const TileId& area) {
    if (overhangs(area)) return split(area);
    SurfacePatch patch{area, from_, surface_, 0, 0, 0, ellipsoid_};
    const int samples_log2 = patch.sample_cells_log2();
    const SquareSphere sphere = sphere_of(patch, samples_log2);
    if (cull_ && !may_be_visible(area, sphere)) return;
    patch.distance_m = std::max(0.0, glm::distance(sphere.centre, eye_) - sphere.radius_m);
    if (samples_log2 > kPatchCellsLog2) return split(area);
    const ScreenErrorBudget::ProjectedScale scale = budget_.scale_of(sphere);
    const bool is_near = scale.depth_m <= 0 || sphere.radius_m > kSmall * scale.depth_m;
    if (is_near && samples_log2 > SquareSpheres::kLeastCellsLog2) return split(area);
    const ScreenErrorBudget::Headroom headroom = budget_.headroom_of(scale);
    const double allowed_m = std::max(ScreenErrorBudget::error_m(headroom, area_.error_m, 0), kNegligible_m);
    const double per_sagitta = std::max(1.0, headroom.per_sagitta), flat_m = sagitta_m(area);
    patch.forced_log2 = forced_log2(flat_m, allowed_m * kSagittaShare / per_sagitta);
    const int most_forced = is_near ? kMostForcedNear : kPatchCellsLog2;
    if (patch.forced_log2 > most_forced && area.level < kMaxLevel) return split(area);
    patch.cells_log2 = std::clamp(std::max(samples_log2, patch.forced_log2), 0, kPatchCellsLog2);
    patch.forced_log2 = std::min(patch.forced_log2, patch.cells_log2);
    const double left_m = allowed_m - std::ldexp(flat_m * per_sagitta, -2 * patch.forced_log2);
    patch.step = VertexSteps::step_within(std::max(left_m, allowed_m * (1 - kSagittaShare)));
    out_.push_back(patch);
  }

  void split(const TileId& area) {
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId child = child_of(area, quadrant);
      if (is_valid(child)) add(child);
    }
  }

 private:
  bool may_be_visible(const TileId& area, const SquareSphere& ground) const {
    SquareSphere all = surface_.tile ? ground : sphere_around(area, 0, kHighest_m, ellipsoid_);
    all.radius_m += area_.reach_m;
    return budget_.may_be_visible(all);
  }

  /// Around the patch's ground. The tile has spheres of larger squares only.
  static SquareSphere sphere_of(const SurfacePatch& patch, int samples_log2) {
    if (!patch.surface.tile) return sphere_around(patch.area, 0, 0, patch.ellipsoid);
    const SurfaceTile& tile = *patch.surface.tile;
    if (samples_log2 >= SquareSpheres::kLeastCellsLog2) return tile.spheres.around(patch.area);
    // Within a cell no place is higher than the highest corner.
    const int cells = samples_log2 > 0 ? 1 << samples_log2 : 1;
    const LatticePoint corner = south_west_of(patch.area);
    const std::int64_t step = lattice_width(patch.area.level) / cells;
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const ShownHeight shown = shown_height_at(patch.surface, {corner.x + i * step, corner.y + j * step});
        const float coarser = shown.finer_m + shown.to_coarser_m;
        low = std::min({low, shown.finer_m, coarser});
        high = std::max({high, shown.finer_m, coarser});
      }
    }
    return sphere_around(patch.area, static_cast<double>(low), static_cast<double>(high), patch.ellipsoid);
  }

  /// How far the body is from a flat square over the area, at most.
  double sagitta_m(const TileId& area) const {
    return sagitta_of_cell_m(glm::radians(tile_width_degrees(area.level)), kHighest_m, ellipsoid_);
  }
  /// How often the square is halved until that is no more than what is allowed.
  static int forced_log2(double flat_m, double allowed_m) {
    const double ratio = flat_m / allowed_m;
    return ratio <= 1 ? 0 : static_cast<int>(std::ceil(std::log2(ratio) / 2));
  }

  const SurfaceArea& area_;
  std::size_t from_;
  const ScreenErrorBudget& budget_;
  bool cull_;
  glm::dvec3 eye_;
  Ellipsoid ellipsoid_;
  ShownSurface surface_;
  std::vector<SurfacePatch>& out_;
};

/// The patches that a neighbour is too fine for.
std::vector<bool> too_coarse(const PatchPartition& partition) {
  std::vector<bool> coarse(partition.patches.size());
  for (const SharedSegment& s : partition.segments) {
    const auto& patches = partition.patches;
    if (patches[s.finer].area.level - patches[s.coarser].area.level > kMaxLevelStep) coarse[s.coarser] = true;
  }
  return coarse;
}

}  // namespace

PatchPartition partition_areas(std::span<const SurfaceArea> areas, const SurfaceRules& rules) {
  const ScreenErrorBudget at_rest(rules.view, rules.tolerance_px, rules.lowest_m);
  const ScreenErrorBudget moving(rules.view, rules.tolerance_px / 2, rules.lowest_m);
  const auto splitter = [&](std::size_t i, std::vector<SurfacePatch>& out) {
    return Splitter(areas[i], i, areas[i].moves ? moving : at_rest, rules, out);
  };
  PatchPartition now;
  for (std::size_t i = 0; i < areas.size(); ++i) splitter(i, now.patches).add(areas[i].area);
  for (;;) {
    now.segments = shared_segments(now.patches);
    const std::vector<bool> coarse = too_coarse(now);
    if (std::find(coarse.begin(), coarse.end(), true) == coarse.end()) return now;
    std::vector<SurfacePatch> finer;
    finer.reserve(now.patches.size());
    for (std::size_t i = 0; i < now.patches.size(); ++i) {
      if (coarse[i]) {
        splitter(now.patches[i].from, finer).split(now.patches[i].area);
      } else {
        finer.push_back(now.patches[i]);
      }
    }
    now.patches = std::move(finer);
  }
}

}  // namespace cairn
