#include "runtime/surface/mesh_plan.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

#include "runtime/surface/patch_partition.h"
#include "runtime/surface/rim_wall.h"

namespace cairn::gl {
namespace {

/// The detail of patches without heights.
constexpr double kNoDetail = -std::numeric_limits<double>::infinity();
double detail_of(const ShownSurface& surface) {
  return surface.tile ? surface.detail : kNoDetail;
}

/// A point as the patches that show so much detail see it.
struct DetailPoint {
  LatticePoint point;
  double detail = kNoDetail;
  friend bool operator==(const DetailPoint&, const DetailPoint&) = default;
};
struct DetailPointHash {
  std::size_t operator()(const DetailPoint& at) const noexcept {
    return std::hash<LatticePoint>()(at.point) ^ (std::hash<double>()(at.detail) << 1);
  }
};

/// The surface that decides at points that some patch which touches them has no sample at.
using Deciders = std::unordered_map<DetailPoint, ShownSurface, DetailPointHash>;

/// What a patch's side is joined to, along a part of it.
struct Joint {
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t spacing = 0;  ///< of the vertices that both have
  ShownSurface surface;
  bool decided = false;  ///< its ends are among the deciders
};
using Joints = std::array<std::vector<Joint>, 4>;

/// Of two of equal detail that of the coarser tile, so that both sides choose the same. They differ only
/// where a void is near.
ShownSurface coarser_of(const ShownSurface& a, const ShownSurface& b) {
  return b.tile && b.tile->id.level < a.tile->id.level ? b : a;
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
    choose_grids();
    join_sides();
    for (std::size_t i = 0; i < patches_.size(); ++i) append_patch(i);
    for (const SharedSegment& s : walled_) note_ends(s);
    for (const SharedSegment& s : walled_) append_wall(s);
    return std::move(plan_);
  }

 private:
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
      const ShownSurface& mine = patches_[s.finer].surface;
      const ShownSurface& theirs = patches_[s.coarser].surface;
      if (detail_of(mine) != detail_of(theirs)) {
        add_joint(s.finer, s.finer_side, {s.along_first, s.along_last, spacing(s.finer), mine});
        add_joint(s.coarser, s.coarser_side(), {s.along_first, s.along_last, spacing(s.coarser), theirs});
        walled_.push_back(s);
        continue;
      }
      const std::int64_t common = std::max(spacing(s.finer), spacing(s.coarser));
      const bool decided = !samples_at_ends(s);
      const Joint joint{s.along_first, s.along_last, common, coarser_of(mine, theirs), decided};
      add_joint(s.finer, s.finer_side, joint);
      add_joint(s.coarser, s.coarser_side(), joint);
      if (decided) decide_ends(s);
    }
  }

  void add_joint(std::size_t patch, Side side, const Joint& joint) {
    joints_[patch][static_cast<std::size_t>(side)].push_back(joint);
  }

  /// Whether the surfaces, which are of equal detail, have samples where the segment ends: else they may
  /// disagree there.
  bool samples_at_ends(const SharedSegment& s) const {
    const ShownSurface& surface = patches_[s.finer].surface;
    return !surface.tile ||
           patches_[s.finer].area.level <= surface.whole_level() + cells_log2_of(rules_.tile_size);
  }

  void decide_ends(const SharedSegment& s) {
    const ShownSurface surface = coarser_of(patches_[s.finer].surface, patches_[s.coarser].surface);
    for (const std::int64_t along : {s.along_first, s.along_last}) {
      const LatticePoint point = canonical(point_on(patches_[s.finer].area, s.finer_side, along));
      const auto [it, fresh] = deciders_.emplace(DetailPoint{point, detail_of(surface)}, surface);
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
    if (!has_samples(own) || !own.tile->exact_on_gpu || has_decided_corner(index, grid, side)) return false;
    const auto& joints = joints_[index][static_cast<std::size_t>(side)];
    return std::all_of(joints.begin(), joints.end(), [&](const Joint& joint) {
      return !joint.decided && joint.spacing <= spacing(index) && has_samples(joint.surface);
    });
  }

  bool has_decided_corner(std::size_t index, const GridPatch& grid, Side side) const {
    if (deciders_.empty()) return false;
    const double detail = detail_of(patches_[index].surface);
    const std::int64_t first = origin_of(grid.area, side);
    const std::int64_t end = is_vertical(side) ? kLatticePoleToPole : kLatticeAround;
    const std::int64_t last = std::min(first + lattice_width(grid.area.level), end);
    return deciders_.contains({canonical(point_on(grid.area, side, first)), detail}) ||
           deciders_.contains({canonical(point_on(grid.area, side, last)), detail});
  }

  void append_side(std::size_t index, const GridPatch& grid, Side side) {
    const std::int64_t origin = origin_of(grid.area, side);
    const int last = is_vertical(side) ? grid.cells_north : grid.cells_east;
    for (int k = 0; k <= grid.cells(); ++k) {
      const auto [along, height] = snap(index, side, origin + std::min(k, last) * spacing(index));
      const auto moved = static_cast<std::uint16_t>((along - origin) / spacing(index));
      plan_.perimeter.push_back(vertex_on(grid, side, moved, height));
    }
  }

  static bool is_vertical(Side side) { return side == Side::west || side == Side::east; }

  /// Where a side of the area begins.
  static std::int64_t origin_of(const TileId& area, Side side) {
    const LatticePoint corner = south_west_of(area);
    return is_vertical(side) ? corner.y : corner.x;
  }

  static PerimeterVertex vertex_on(const GridPatch& grid, Side side, std::uint16_t k, float height_m) {
    const auto east = static_cast<std::uint16_t>(side == Side::west ? 0 : grid.cells_east);
    const auto north = static_cast<std::uint16_t>(side == Side::south ? 0 : grid.cells_north);
    return is_vertical(side) ? PerimeterVertex{east, k, height_m} : PerimeterVertex{k, north, height_m};
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
      const auto it = deciders_.find({canonical(point), detail_of(surface)});
      if (it != deciders_.end()) surface = it->second;
    }
    return {along, height_from(surface, point)};
  }

  /// What the walls that end at a point have to pass.
  void note_ends(const SharedSegment& s) {
    for (const std::int64_t along : {s.along_first, s.along_last}) {
      std::vector<float>& heights = end_heights_[end_of(s, along)];
      for (const float height :
           {snap(s.finer, s.finer_side, along).height_m, snap(s.coarser, s.coarser_side(), along).height_m}) {
        const auto place = std::lower_bound(heights.begin(), heights.end(), height);
        if (!std::isnan(height) && (place == heights.end() || *place != height)) {
          heights.insert(place, height);
        }
      }
    }
  }

  /// A segment's end; all of a pole's are one.
  LatticePoint end_of(const SharedSegment& s, std::int64_t along) const {
    LatticePoint point = canonical(point_on(patches_[s.finer].area, s.finer_side, along));
    if (point.y == 0 || point.y == kLatticePoleToPole) point.x = 0;
    return point;
  }

  void append_wall(const SharedSegment& s) {
    // Of a place without heights and terrain, the wall belongs to the former: it is where what is known ends.
    const bool of_finer = patches_[s.coarser].surface.tile != nullptr;
    const auto rim = [&](std::size_t index, Side side) {
      std::vector<RimVertex> vertices;
      for (std::int64_t along = s.along_first; along <= s.along_last; along += spacing(index)) {
        const float height = snap(index, side, along).height_m;
        const GridPatch& grid = plan_.patches[index];
        const auto k = static_cast<std::uint16_t>((along - origin_of(grid.area, side)) / spacing(index));
        WallVertex vertex{static_cast<std::uint32_t>(index), 0, vertex_on(grid, side, k, height)};
        show(vertex, of_finer ? s.finer : s.coarser, of_finer ? s.finer_side : s.coarser_side(), along);
        vertices.push_back({along, vertex});
      }
      return vertices;
    };
    gl::append_wall(rim(s.finer, s.finer_side), rim(s.coarser, s.coarser_side()),
                    end_heights_.at(end_of(s, s.along_first)), end_heights_.at(end_of(s, s.along_last)),
                    plan_);
  }

  /// Gives a wall's vertex the colours of a patch, whose side the wall stands on.
  void show(WallVertex& vertex, std::size_t index, Side side, std::int64_t along) const {
    const GridPatch& grid = plan_.patches[index];
    const auto width = static_cast<double>(lattice_width(grid.area.level));
    const double part = static_cast<double>(along - origin_of(grid.area, side)) / width;
    const double across = side == Side::east    ? static_cast<double>(grid.cells_east) / grid.cells()
                          : side == Side::north ? static_cast<double>(grid.cells_north) / grid.cells()
                                                : 0;
    vertex.shown_as = static_cast<std::uint32_t>(index);
    vertex.place = is_vertical(side) ? glm::vec2(across, part) : glm::vec2(part, across);
  }

  const MeshRules rules_;
  std::vector<Patch> patches_;
  std::vector<SharedSegment> segments_;
  std::vector<SharedSegment> walled_;  // those whose sides show different detail
  std::unordered_map<LatticePoint, std::vector<float>> end_heights_;
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
