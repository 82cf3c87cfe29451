#include "runtime/gl/mesh_plan.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <unordered_map>

#include "runtime/gl/patch_partition.h"

namespace cairn::gl {
namespace {

/// The surface that decides at points that some patch which touches them has no sample at.
using Deciders = std::unordered_map<LatticePoint, ShownSurface>;

/// What a patch's side is joined to, along a part of it.
struct Joint {
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t spacing = 0;  ///< of the vertices that both have
  ShownSurface surface;
  bool decided = false;  ///< its ends are among the deciders
};
using Joints = std::array<std::vector<Joint>, 4>;

/// The one shown with less detail, of equal ones that of the coarser tile, so that both sides choose the
/// same. No surface (height 0) is the coarsest.
ShownSurface coarser_of(const ShownSurface& a, const ShownSurface& b) {
  if (!a.tile || !b.tile) return {};
  if (a.detail != b.detail) return b.detail < a.detail ? b : a;
  return b.tile->id.level < a.tile->id.level ? b : a;
}

float height_from(const ShownSurface& surface, LatticePoint point) {
  if (!surface.tile) return 0;
  const std::int64_t west = south_west_of(surface.tile->id).x;
  if (point.x < west) point.x += kLatticeAround;
  if (point.x > west + lattice_width(surface.tile->id.level)) point.x -= kLatticeAround;
  return height_at(surface, point);
}

/// The fewest cells that have a vertex at the end of the world, where the tile overhangs it.
int cells_log2_of_overhang(const TileId& area) {
  const LatticePoint corner = south_west_of(area);
  const std::int64_t width = lattice_width(area.level);
  int cells_log2 = 0;
  for (const std::int64_t inside : {kLatticeAround - corner.x, kLatticePoleToPole - corner.y}) {
    while (inside < width && inside % (width >> cells_log2) != 0) ++cells_log2;
  }
  return cells_log2;
}

class Planner {
 public:
  Planner(std::span<const MeshArea> areas, const MeshRules& rules)
      : rules_(rules), patches_(partition_areas(areas, rules)), segments_(shared_segments(patches_)) {}

  MeshPlan plan() {
    mark_touched();
    choose_grids();
    join_sides();
    for (std::size_t i = 0; i < patches_.size(); ++i) append_patch(i);
    return std::move(plan_);
  }

 private:
  /// A rim moves with whichever side of it moves.
  void mark_touched() {
    std::vector<bool> touched(patches_.size());
    for (const SharedSegment& s : segments_) {
      if (patches_[s.finer].moves) touched[s.coarser] = true;
      if (patches_[s.coarser].moves) touched[s.finer] = true;
    }
    for (std::size_t i = 0; i < patches_.size(); ++i) patches_[i].moves = patches_[i].moves || touched[i];
  }

  void choose_grids() {
    for (const Patch& patch : patches_) {
      cells_log2_.push_back(std::max(cells_log2_for_eye(patch, rules_), cells_log2_of_overhang(patch.area)));
    }
    for (const SharedSegment& s : segments_) {
      const int step = patches_[s.finer].area.level - patches_[s.coarser].area.level;
      cells_log2_[s.coarser] = std::max(cells_log2_[s.coarser], step);
    }
  }

  std::int64_t spacing(std::size_t patch) const {
    return lattice_width(patches_[patch].area.level + cells_log2_[patch]);
  }

  void join_sides() {
    joints_.resize(patches_.size());
    for (const SharedSegment& s : segments_) {
      const std::int64_t common = std::max(spacing(s.finer), spacing(s.coarser));
      const ShownSurface& mine = patches_[s.finer].surface;
      const ShownSurface& theirs = patches_[s.coarser].surface;
      const bool decided = !samples_at_ends(s);
      add_joint(s.finer, s.finer_side,
                {s.along_first, s.along_last, common, coarser_of(mine, theirs), decided});
      add_joint(s.coarser, s.coarser_side(),
                {s.along_first, s.along_last, common, coarser_of(theirs, mine), decided});
      if (decided) decide_ends(s);
    }
  }

  void add_joint(std::size_t patch, Side side, const Joint& joint) {
    joints_[patch][static_cast<std::size_t>(side)].push_back(joint);
  }

  /// Whether both surfaces have samples where the segment ends: else they disagree there.
  bool samples_at_ends(const SharedSegment& s) const {
    const ShownSurface& a = patches_[s.finer].surface;
    const ShownSurface& b = patches_[s.coarser].surface;
    if (!a.tile || !b.tile) return a.tile == b.tile;
    const int coarser = std::min(a.whole_level(), b.whole_level());
    return patches_[s.finer].area.level <= coarser + cells_log2_of(rules_.tile_size);
  }

  void decide_ends(const SharedSegment& s) {
    const ShownSurface surface = coarser_of(patches_[s.finer].surface, patches_[s.coarser].surface);
    for (const std::int64_t along : {s.along_first, s.along_last}) {
      const LatticePoint point = canonical(point_on(patches_[s.finer].area, s.finer_side, along));
      const auto [it, fresh] = deciders_.emplace(point, surface);
      if (!fresh) it->second = coarser_of(it->second, surface);
    }
  }

  static LatticePoint point_on(const TileId& area, Side side, std::int64_t along) {
    const LatticePoint corner = south_west_of(area);
    const std::int64_t width = lattice_width(area.level);
    switch (side) {
      case Side::south:
        return {along, corner.y};
      case Side::north:
        return {along, std::min(corner.y + width, kLatticePoleToPole)};
      case Side::west:
        return {corner.x, along};
      default:
        return {std::min(corner.x + width, kLatticeAround), along};
    }
  }

  void append_patch(std::size_t index) {
    const Patch& patch = patches_[index];
    const LatticePoint corner = south_west_of(patch.area);
    const int cells = 1 << cells_log2_[index];
    GridPatch grid{patch.area, patch.from, cells_log2_[index], cells, cells, 0, plan_.perimeter.size()};
    const std::int64_t step = spacing(index);
    grid.cells_east = static_cast<int>(std::min<std::int64_t>(cells, (kLatticeAround - corner.x) / step));
    grid.cells_north =
        static_cast<int>(std::min<std::int64_t>(cells, (kLatticePoleToPole - corner.y) / step));
    for (Side side : {Side::south, Side::north, Side::west, Side::east}) {
      if (is_plain(index, grid, side)) continue;
      grid.listed_sides |= 1u << static_cast<unsigned>(side);
      append_side(index, grid, side);
    }
    plan_.patches.push_back(grid);
  }

  /// Whether the side is drawn with the patch's own samples where they are, so that the GPU has all of it.
  bool is_plain(std::size_t index, const GridPatch& grid, Side side) const {
    const int finest_of_tile = cells_log2_of(rules_.tile_size);
    const int lattice = grid.area.level + grid.cells_log2;
    const auto has_samples = [&](const ShownSurface& surface) {
      return surface.tile && lattice <= surface.whole_level() + finest_of_tile;
    };
    const ShownSurface& own = patches_[index].surface;
    if (!has_samples(own) || !own.tile->exact_on_gpu || has_decided_corner(grid, side)) return false;
    const auto& joints = joints_[index][static_cast<std::size_t>(side)];
    return std::all_of(joints.begin(), joints.end(), [&](const Joint& joint) {
      return !joint.decided && joint.spacing <= spacing(index) && has_samples(joint.surface);
    });
  }

  bool has_decided_corner(const GridPatch& grid, Side side) const {
    if (deciders_.empty()) return false;
    const LatticePoint corner = south_west_of(grid.area);
    const bool vertical = side == Side::west || side == Side::east;
    const std::int64_t first = vertical ? corner.y : corner.x;
    const std::int64_t end = vertical ? kLatticePoleToPole : kLatticeAround;
    const std::int64_t last = std::min(first + lattice_width(grid.area.level), end);
    return deciders_.contains(canonical(point_on(grid.area, side, first))) ||
           deciders_.contains(canonical(point_on(grid.area, side, last)));
  }

  void append_side(std::size_t index, const GridPatch& grid, Side side) {
    const LatticePoint corner = south_west_of(grid.area);
    const bool vertical = side == Side::west || side == Side::east;
    const std::int64_t origin = vertical ? corner.y : corner.x;
    const std::int64_t step = spacing(index);
    const int last = vertical ? grid.cells_north : grid.cells_east;
    for (int k = 0; k <= grid.cells(); ++k) {
      const std::int64_t along = origin + std::min(k, last) * step;
      const auto [snapped, height] = snap(index, side, along);
      const auto moved = static_cast<std::uint16_t>((snapped - origin) / step);
      const auto east = static_cast<std::uint16_t>(side == Side::west ? 0 : grid.cells_east);
      const auto north = static_cast<std::uint16_t>(side == Side::south ? 0 : grid.cells_north);
      plan_.perimeter.push_back(vertical ? PerimeterVertex{east, moved, height}
                                         : PerimeterVertex{moved, north, height});
    }
  }

  struct Snapped {
    std::int64_t along = 0;
    float height_m = 0;
  };
  Snapped snap(std::size_t index, Side side, std::int64_t along) const {
    ShownSurface surface = patches_[index].surface;
    for (const Joint& joint : joints_[index][static_cast<std::size_t>(side)]) {
      if (along < joint.first || along > joint.last) continue;
      along = (along + joint.spacing / 2) / joint.spacing * joint.spacing;
      surface = joint.surface;
      break;
    }
    const LatticePoint point = point_on(patches_[index].area, side, along);
    if (!deciders_.empty()) {
      if (const auto it = deciders_.find(canonical(point)); it != deciders_.end()) surface = it->second;
    }
    return {along, height_from(surface, point)};
  }

  const MeshRules rules_;
  std::vector<Patch> patches_;
  std::vector<SharedSegment> segments_;
  std::vector<int> cells_log2_;
  std::vector<Joints> joints_;
  Deciders deciders_;
  MeshPlan plan_;
};

}  // namespace

MeshPlan plan_mesh(std::span<const MeshArea> areas, const MeshRules& rules) {
  return Planner(areas, rules).plan();
}

}  // namespace cairn::gl
