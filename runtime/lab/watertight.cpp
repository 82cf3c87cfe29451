#include "runtime/lab/watertight.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace cairn {
namespace {

/// A side of a triangle.
struct Edge {
  LatticePoint from;
  LatticePoint to;
};

/// The same, by its ends' numbers, so that both sides of a seam sort beside each other.
struct NumberedEdge {
  std::uint64_t ends = 0;  ///< the lesser number in the high half
  std::uint32_t tile = 0;
  std::uint32_t side = 0;  ///< twice that of the tile's mesh, plus whether it runs from the greater number
};

class Edges {
 public:
  explicit Edges(const LodMesh& mesh) : mesh_(mesh) {
    std::size_t vertices = mesh.walls.vertices.size();
    for (const LodTileMesh& tile : mesh.tiles) vertices += tile.vertices.size();
    numbers_.reserve(vertices);
    edges_.reserve(3 * mesh.triangle_count());
    for (std::size_t i = 0; i < mesh.tiles.size(); ++i) add(mesh.tiles[i], static_cast<std::uint32_t>(i));
    add(mesh.walls, kWalls);
    std::sort(edges_.begin(), edges_.end(),
              [](const NumberedEdge& a, const NumberedEdge& b) { return a.ends < b.ends; });
  }

  template <class IsOuter>
  std::uint64_t count_cracks(IsOuter is_outer) const {
    std::uint64_t cracks = 0;
    for (std::size_t i = 0; i < edges_.size();) {
      std::size_t end = i;
      std::uint32_t backward = 0;
      bool is_walled = false;
      for (; end < edges_.size() && edges_[end].ends == edges_[i].ends; ++end) {
        backward += edges_[end].side & 1;
        is_walled |= edges_[end].tile == kWalls;
      }
      // Where walls meet at an upright edge, or both rims have one, there may be twice two.
      const bool joined = is_walled ? (end - i) % 2 == 0 || is_at_pole(edge(edges_[i])) ||
                                          ends_at_border(edge(edges_[i]), is_outer)
                                    : end - i == 2 && backward == 1;
      cracks += !joined && !(end - i == 1 && is_outer(edge(edges_[i])));
      i = end;
    }
    return cracks;
  }

 private:
  static constexpr std::uint32_t kWalls = 0xFFFFFFFFu;

  const LodTileMesh& tile_of(const NumberedEdge& e) const {
    return e.tile == kWalls ? mesh_.walls : mesh_.tiles[e.tile];
  }

  /// Where a wall ends at the border of the map there is no other to share its upright edge.
  template <class IsOuter>
  static bool ends_at_border(const Edge& edge, IsOuter is_outer) {
    return edge.from == edge.to && is_outer(edge);
  }

  /// A pole is one place on all meridians.
  static bool is_at_pole(const Edge& edge) {
    return edge.from.y == edge.to.y && (edge.from.y == 0 || edge.from.y == kLatticePoleToPole);
  }

  void add(const LodTileMesh& tile, std::uint32_t index) {
    std::vector<std::uint32_t> numbers;
    numbers.reserve(tile.vertices.size());
    for (const LodVertex& v : tile.vertices) {
      const LodVertex key{canonical(v.point), v.height_m};
      numbers.push_back(numbers_.emplace(key, static_cast<std::uint32_t>(numbers_.size())).first->second);
    }
    for (std::size_t t = 0; t < tile.triangles.size(); ++t) {
      for (std::size_t side = 0; side < 3; ++side) {
        const std::uint64_t a = numbers[tile.triangles[t][side]],
                            b = numbers[tile.triangles[t][(side + 1) % 3]];
        edges_.push_back({std::min(a, b) << 32 | std::max(a, b), index,
                          static_cast<std::uint32_t>(2 * (3 * t + side) + (a > b ? 1 : 0))});
      }
    }
  }

  Edge edge(const NumberedEdge& e) const {
    const LodTileMesh& tile = tile_of(e);
    const LodTriangle& t = tile.triangles[e.side / 6];
    const std::size_t side = e.side / 2 % 3;
    return {tile.vertices[t[side]].point, tile.vertices[t[(side + 1) % 3]].point};
  }

  const LodMesh& mesh_;
  std::unordered_map<LodVertex, std::uint32_t, LodVertexHash> numbers_;
  std::vector<NumberedEdge> edges_;
};

/// Which places the scene's areas cover.
class Covered {
 public:
  explicit Covered(const LodScene& scene) {
    for (const LodTile& tile : scene.tiles) areas_.insert(tile.area);
  }

  /// Whether what lies to the right of the edge, seen from above along it, is outside all areas.
  bool is_outer(const Edge& edge) const {
    const std::int64_t dx = edge.to.x - edge.from.x, dy = edge.to.y - edge.from.y;
    if (dx != 0 && dy != 0) return false;
    if (dx == 0 && dy == 0) {
      const std::int64_t x = 2 * edge.from.x, y = 2 * edge.from.y;
      return !has(x - 1, y - 1) || !has(x + 1, y - 1) || !has(x - 1, y + 1) || !has(x + 1, y + 1);
    }
    const auto sign = [](std::int64_t v) { return (v > 0) - (v < 0); };
    // Doubled coordinates, so that the point beside the edge is never on a border.
    return !has(edge.from.x + edge.to.x + sign(dy), edge.from.y + edge.to.y - sign(dx));
  }

 private:
  bool has(std::int64_t twice_x, std::int64_t twice_y) const {
    if (twice_y < 0 || twice_y > 2 * kLatticePoleToPole) return false;
    const std::int64_t x = ((twice_x >> 1) + kLatticeAround) % kLatticeAround, y = twice_y >> 1;
    for (int level = kMinLevel; level <= kMaxLevel; ++level) {
      const std::int64_t width = lattice_width(level);
      if (areas_.contains(
              {level, static_cast<std::int32_t>(x / width), static_cast<std::int32_t>(y / width)})) {
        return true;
      }
    }
    return false;
  }

  std::unordered_set<TileId> areas_;
};

/// Twice the area, in double: exact up to 2^53, and beyond to 1e-16 of it.
double doubled_area(const LodTileMesh& tile, const LodTriangle& t) {
  const LatticePoint a = tile.vertices[t[0]].point, b = tile.vertices[t[1]].point,
                     c = tile.vertices[t[2]].point;
  return static_cast<double>(b.x - a.x) * static_cast<double>(c.y - a.y) -
         static_cast<double>(c.x - a.x) * static_cast<double>(b.y - a.y);
}

}  // namespace

MeshFaults find_faults(const LodScene& scene, const LodMesh& mesh) {
  MeshFaults faults;
  const Covered covered(scene);
  faults.cracks = Edges(mesh).count_cracks([&](const Edge& edge) { return covered.is_outer(edge); });
  double expected = 0, found = 0;
  for (const LodTile& tile : scene.tiles) {
    const auto width = static_cast<double>(lattice_width(tile.area.level));
    expected += 2 * width * width;
  }
  for (const LodTileMesh& tile : mesh.tiles) {
    for (const LodTriangle& t : tile.triangles) {
      const double area = doubled_area(tile, t);
      faults.degenerate += !(area > 0);
      found += area;
    }
  }
  faults.area_error = expected > 0 ? std::abs(found - expected) / expected : 0;
  return faults;
}

}  // namespace cairn
