#include "runtime/surface/rim_walls.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <tuple>
#include <unordered_map>

#include "runtime/surface/patch_mesh.h"

namespace cairn {
namespace {

/// A vertex of a rim. Two at one place are the same where they have the same heights and glide alike.
struct RimVertex {
  std::int64_t along = 0;  // lattice units: longitude or latitude
  SurfaceWallVertex vertex;
  float coarser_share = 0;
  bool is_void = false;

  float shown_m() const { return vertex.vertex.height_m + vertex.vertex.to_coarser_m * coarser_share; }
  auto heights() const {
    return std::tuple(shown_m(), vertex.vertex.height_m, vertex.vertex.to_coarser_m, coarser_share);
  }
};

bool is_same(const RimVertex& a, const RimVertex& b) {
  return a.along == b.along && a.heights() == b.heights();
}

class WallBuilder {
 public:
  WallBuilder(const PatchPartition& partition, const SideJoints& joints, SurfaceWalls& walls)
      : patches_(partition.patches), joints_(joints), walls_(walls) {}

  void run() {
    for (const SharedSegment& s : joints_.walled) {
      for (const std::int64_t along : {s.first, s.last}) {
        auto& there = ends_[end_of(s, along)];
        for (const auto& [patch, side] :
             {std::pair(s.finer, s.finer_side), std::pair(s.coarser, s.coarser_side())})
          note(vertex_at(patch, side, along), leaves_voids_open(s), there);
      }
    }
    for (const SharedSegment& s : joints_.walled) append(s);
  }

 private:
  /// Whether no wall stands at a void: where a source ends there. Between two tiles the fragments mask it.
  bool leaves_voids_open(const SharedSegment& s) const {
    return !patches_[s.finer].surface.tile || !patches_[s.coarser].surface.tile;
  }

  static void note(const RimVertex& vertex, bool leaves_voids_open, std::vector<RimVertex>& there) {
    if (leaves_voids_open && vertex.is_void) return;
    const auto at =
        std::lower_bound(there.begin(), there.end(), vertex,
                         [](const RimVertex& a, const RimVertex& b) { return a.heights() < b.heights(); });
    if (at == there.end() || at->heights() != vertex.heights()) there.insert(at, vertex);
  }

  /// The place of a segment's end, the same for every segment that ends there.
  LatticePoint end_of(const SharedSegment& s, std::int64_t along) const {
    const TileId& area = patches_[s.finer].area;
    const LatticePoint corner = south_west_of(area);
    const std::int64_t width = lattice_width(area.level);
    LatticePoint point{along, corner.y + (s.finer_side == Side::north ? width : 0)};
    if (is_vertical(s.finer_side)) point = {corner.x + (s.finer_side == Side::east ? width : 0), along};
    point = canonical(point);
    // A pole is one place, on whichever meridian.
    if (point.y == 0 || point.y == kLatticePoleToPole) point.x = 0;
    return point;
  }

  RimVertex vertex_at(std::size_t index, Side side, std::int64_t along) const {
    const SurfacePatch& patch = patches_[index];
    const auto k = static_cast<int>((along - begin_of(patch.area, side)) /
                                    lattice_width(patch.area.level + patch.cells_log2));
    const int far = patch.cells();
    const int column = is_vertical(side) ? (side == Side::east ? far : 0) : k;
    const int row = is_vertical(side) ? k : side == Side::north ? far : 0;
    const PatchVertices::Vertex made = PatchVertices(patch).at(column, row);
    const auto number = static_cast<std::uint32_t>(index);
    return {along, {made.vertex, number, number}, patch.surface.coarser_share(), made.is_void};
  }

  std::vector<RimVertex> rim_of(const SharedSegment& s, std::size_t index, Side side) const {
    const SurfacePatch& patch = patches_[index];
    const std::int64_t begin = begin_of(patch.area, side);
    const std::int64_t spacing = lattice_width(patch.area.level + patch.cells_log2);
    const auto first = static_cast<int>((s.first - begin) / spacing);
    const auto last = static_cast<int>((s.last - begin) / spacing);
    const std::uint64_t vertices = of_side(joints_.sides[index], side);
    std::vector<RimVertex> rim;
    for (int i = first; i <= last; ++i) {
      const bool is_there = i == first || i == last || (vertices >> i & 1) != 0;
      if (is_there) rim.push_back(vertex_at(index, side, begin + i * spacing));
    }
    return rim;
  }

  /// The vertices strictly between two ends of rims at one place, on the way from the one to the other.
  static void add_between(const RimVertex& from, const RimVertex& to, std::span<const RimVertex> there,
                          std::vector<RimVertex>& out) {
    const auto low = std::min(from.heights(), to.heights()), high = std::max(from.heights(), to.heights());
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    for (const RimVertex& vertex : there) {
      if (!(vertex.heights() > low && vertex.heights() < high)) continue;
      out.push_back(vertex);
      out.back().along = from.along;
    }
    if (from.heights() > to.heights()) std::reverse(out.begin() + first, out.end());
  }

  void append(const SharedSegment& s) {
    const std::vector<RimVertex> a = rim_of(s, s.finer, s.finer_side);
    const std::vector<RimVertex> b = rim_of(s, s.coarser, s.coarser_side());
    // The second rim goes from the first one's beginning to its end.
    std::vector<RimVertex> around;
    add_between(a.front(), b.front(), ends_.at(end_of(s, s.first)), around);
    around.insert(around.end(), b.begin(), b.end());
    add_between(b.back(), a.back(), ends_.at(end_of(s, s.last)), around);
    // Of a place without heights and terrain, the wall belongs to the former: it is where what is known ends.
    const bool finer_shows = patches_[s.coarser].surface.tile != nullptr;
    const std::size_t shown = finer_shows ? s.finer : s.coarser;
    const Side side = finer_shows ? s.finer_side : s.coarser_side();
    const auto first_of_a = static_cast<std::uint32_t>(walls_.vertices.size());
    const auto first_of_b = static_cast<std::uint32_t>(first_of_a + a.size());
    for (const RimVertex& vertex : a) walls_.vertices.push_back(shown_as(vertex, shown, side));
    for (const RimVertex& vertex : around) walls_.vertices.push_back(shown_as(vertex, shown, side));
    const bool open_voids = leaves_voids_open(s);
    join(open_voids ? all_of(a, first_of_a) : lowered(a, around, first_of_a),
         open_voids ? all_of(around, first_of_b) : lowered(around, a, first_of_b), open_voids);
  }

  /// A vertex of a rim and its number among the walls' vertices.
  struct Numbered {
    const RimVertex* rim;
    std::uint32_t number;
  };

  static std::vector<Numbered> all_of(std::span<const RimVertex> rim, std::uint32_t first) {
    std::vector<Numbered> all;
    for (const RimVertex& vertex : rim) all.push_back({&vertex, first++});
    return all;
  }

  /// Whether a vertex lies above the line between the one before and the one after it.
  static bool stands_up(const RimVertex& before, const RimVertex& vertex, const RimVertex& after) {
    const auto rise = [](const RimVertex& from, const RimVertex& to) {
      return static_cast<double>(to.shown_m()) - static_cast<double>(from.shown_m());
    };
    return rise(before, vertex) * static_cast<double>(after.along - vertex.along) >
           rise(vertex, after) * static_cast<double>(vertex.along - before.along);
  }

  /// Cuts triangles off a rim until no vertex stands up but those that the other rim has, too, and returns
  /// what is left. They lie below the rim. Triangles from rim to rim alone would stand out above both where
  /// these cross.
  std::vector<Numbered> lowered(std::span<const RimVertex> rim, std::span<const RimVertex> other,
                                std::uint32_t first) {
    std::vector<Numbered> left;
    const auto is_of_both = [&](const RimVertex& vertex) {
      auto at = std::lower_bound(other.begin(), other.end(), vertex,
                                 [](const RimVertex& a, const RimVertex& b) { return a.along < b.along; });
      for (; at != other.end() && at->along == vertex.along; ++at) {
        if (is_same(*at, vertex)) return true;
      }
      return false;
    };
    for (const Numbered& next : all_of(rim, first)) {
      while (left.size() > 1) {
        const Numbered &before = left[left.size() - 2], &last = left.back();
        if (!stands_up(*before.rim, *last.rim, *next.rim) || is_of_both(*last.rim)) break;
        add(before, last, next);
        left.pop_back();
      }
      left.push_back(next);
    }
    return left;
  }

  void add(const Numbered& a, const Numbered& b, const Numbered& c) {
    if (is_same(*a.rim, *b.rim) || is_same(*a.rim, *c.rim) || is_same(*b.rim, *c.rim)) return;
    walls_.indices.insert(walls_.indices.end(), {a.number, b.number, c.number});
  }

  /// Fills what is between two rims that begin at one place and end at another.
  void join(const std::vector<Numbered>& a, const std::vector<Numbered>& b, bool open_voids) {
    for (std::size_t i = 0, j = 0; i + 1 < a.size() || j + 1 < b.size();) {
      const bool of_a = i + 1 < a.size() && (j + 1 == b.size() || a[i + 1].rim->along < b[j + 1].rim->along);
      const Numbered& third = of_a ? a[i + 1] : b[j + 1];
      const bool is_open = open_voids && (a[i].rim->is_void || b[j].rim->is_void || third.rim->is_void);
      if (!is_open) add(a[i], b[j], third);
      of_a ? ++i : ++j;
    }
  }

  /// With the colours of a patch on whose side the wall stands.
  SurfaceWallVertex shown_as(const RimVertex& vertex, std::size_t index, Side side) const {
    const SurfacePatch& patch = patches_[index];
    const std::int64_t width = lattice_width(patch.area.level);
    const std::int64_t part = (vertex.along - begin_of(patch.area, side)) * kSurfaceSide / width;
    SurfaceWallVertex out = vertex.vertex;
    out.shown_as = static_cast<std::uint32_t>(index);
    const auto across =
        static_cast<std::uint16_t>(side == Side::east || side == Side::north ? kSurfaceSide : 0);
    out.vertex.east = is_vertical(side) ? across : static_cast<std::uint16_t>(part);
    out.vertex.north = is_vertical(side) ? static_cast<std::uint16_t>(part) : across;
    return out;
  }

  const std::vector<SurfacePatch>& patches_;
  const SideJoints& joints_;
  SurfaceWalls& walls_;
  std::unordered_map<LatticePoint, std::vector<RimVertex>> ends_;
};

}  // namespace

void append_walls(const PatchPartition& partition, const SideJoints& joints, SurfaceWalls& walls) {
  WallBuilder(partition, joints, walls).run();
}

}  // namespace cairn
