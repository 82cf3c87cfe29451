#include "runtime/lod/mesh/remove_t_junctions.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace cairn {
namespace {

/// A vertex on a line of constant longitude or latitude; `along` is its place on the line.
struct LineVertex {
  std::int64_t along = 0;
  double height_m = 0;
};
using Line = std::vector<LineVertex>;
using Lines = std::unordered_map<std::int64_t, Line>;

struct Area {
  explicit Area(const TileId& id) : Area(MeshArea{south_west_of(id), lattice_width(id.level)}) {}
  explicit Area(const MeshArea& square) : low(square.low), high{low.x + square.width, low.y + square.width} {}
  bool on_vertical(const LatticePoint& p) const { return p.x == low.x || p.x == high.x; }
  bool on_horizontal(const LatticePoint& p) const { return p.y == low.y || p.y == high.y; }

  LatticePoint low;
  LatticePoint high;
};

/// All vertices on the areas' borders, by the line that they lie on.
class BorderVertices {
 public:
  BorderVertices(std::span<const Area> areas, std::span<const LodTileMesh> meshes) {
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      const Area& area = areas[i];
      for (const LodVertex& v : meshes[i].vertices) {
        if (area.on_vertical(v.point)) vertical_[canonical(v.point).x].push_back({v.point.y, v.height_m});
        if (area.on_horizontal(v.point)) horizontal_[v.point.y].push_back({v.point.x, v.height_m});
      }
    }
    for (Lines* lines : {&vertical_, &horizontal_}) {
      for (auto& [at, line] : *lines) sort_unique(line);
    }
  }

  /// Returns the middle one of the vertices strictly between the ends of an edge on a border, nullopt if
  /// there is none.
  std::optional<LodVertex> between(const LatticePoint& a, const LatticePoint& b) const {
    const bool upright = a.x == b.x;
    const Line& line = upright ? vertical_.at(canonical(a).x) : horizontal_.at(a.y);
    const std::int64_t from = upright ? a.y : a.x, to = upright ? b.y : b.x;
    const auto before = [](const LineVertex& v, std::int64_t along) { return v.along < along; };
    const auto first = std::lower_bound(line.begin(), line.end(), std::min(from, to) + 1, before);
    const auto last = std::lower_bound(first, line.end(), std::max(from, to), before);
    if (first == last) return std::nullopt;
    const LineVertex& middle = first[(last - first) / 2];
    return LodVertex{upright ? LatticePoint{a.x, middle.along} : LatticePoint{middle.along, a.y},
                     middle.height_m};
  }

 private:
  static void sort_unique(Line& line) {
    std::sort(line.begin(), line.end(),
              [](const LineVertex& a, const LineVertex& b) { return a.along < b.along; });
    line.erase(std::unique(line.begin(), line.end(),
                           [](const LineVertex& a, const LineVertex& b) { return a.along == b.along; }),
               line.end());
  }

  Lines vertical_;
  Lines horizontal_;
};

/// Splits the triangles of one tile.
class Splitter {
 public:
  Splitter(const Area& area, const BorderVertices& borders, LodTileMesh& mesh)
      : area_(area), borders_(borders), mesh_(mesh) {}

  void split_all() {
    const std::size_t count = mesh_.triangles.size();
    for (std::size_t i = 0; i < count; ++i) split(i);
  }

 private:
  /// Halves the triangle at the middle one of the vertices on an edge, until no edge has any. Where only one
  /// edge has vertices, the result is the fan around the opposite corner.
  void split(std::size_t index) {
    for (std::size_t side = 0; side < 3; ++side) {
      const LodTriangle t = mesh_.triangles[index];
      const std::uint32_t a = t[side], b = t[(side + 1) % 3], opposite = t[(side + 2) % 3];
      const LatticePoint from = mesh_.vertices[a].point, to = mesh_.vertices[b].point;
      if (!on_border(from, to)) continue;
      const auto middle = borders_.between(from, to);
      if (!middle) continue;
      const std::uint32_t m = number_of(*middle);
      mesh_.triangles[index] = {a, m, opposite};
      mesh_.triangles.push_back({m, b, opposite});
      split(mesh_.triangles.size() - 1);
      split(index);
      return;
    }
  }

  bool on_border(const LatticePoint& a, const LatticePoint& b) const {
    return (a.x == b.x && area_.on_vertical(a)) || (a.y == b.y && area_.on_horizontal(a));
  }

  std::uint32_t number_of(const LodVertex& vertex) {
    const auto [it, fresh] =
        inserted_.emplace(vertex.point, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (fresh) mesh_.vertices.push_back(vertex);
    return it->second;
  }

  const Area area_;
  const BorderVertices& borders_;
  LodTileMesh& mesh_;
  std::unordered_map<LatticePoint, std::uint32_t> inserted_;
};

struct BorderHeight {
  int level = kMinLevel - 1;
  double height_m = 0;
};

bool has_voids(const LodScene& scene) {
  return std::any_of(scene.tiles.begin(), scene.tiles.end(),
                     [](const LodTile& tile) { return !tile.heights->voids.empty(); });
}

}  // namespace

void unify_border_heights(const LodScene& scene, LodMesh& mesh) {
  if (!has_voids(scene)) return;
  std::unordered_map<LatticePoint, BorderHeight> heights;
  const auto for_border = [&](auto use) {
    for (LodTileMesh& tile : mesh.tiles) {
      const Area area(scene.tiles[tile.tile].area);
      for (LodVertex& v : tile.vertices) {
        if (area.on_vertical(v.point) || area.on_horizontal(v.point)) use(tile.tile, v);
      }
    }
  };
  for_border([&](std::size_t tile, const LodVertex& v) {
    const int level = scene.tiles[tile].source.level;
    BorderHeight& d = heights[canonical(v.point)];
    if (level > d.level || (level == d.level && v.height_m < d.height_m)) d = {level, v.height_m};
  });
  for_border([&](std::size_t, LodVertex& v) { v.height_m = heights.at(canonical(v.point)).height_m; });
}

void remove_t_junctions(const LodScene& scene, LodMesh& mesh) {
  remove_t_junctions(scene, std::vector<char>(scene.tiles.size(), 1), mesh);
}

void remove_t_junctions(const LodScene& scene, std::span<const char> lacking, LodMesh& mesh) {
  unify_border_heights(scene, mesh);
  const auto lacks = [&](const LodTileMesh& tile) { return lacking[tile.tile] != 0; };
  if (std::none_of(mesh.tiles.begin(), mesh.tiles.end(), lacks)) return;
  std::vector<Area> areas;
  for (const LodTileMesh& tile : mesh.tiles) areas.emplace_back(scene.tiles[tile.tile].area);
  const BorderVertices borders(areas, mesh.tiles);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (lacks(mesh.tiles[i])) Splitter(areas[i], borders, mesh.tiles[i]).split_all();
  }
}

void split_at_borders(std::span<const MeshArea> squares, std::span<LodTileMesh> meshes) {
  const std::vector<Area> areas(squares.begin(), squares.end());
  const BorderVertices borders(areas, meshes);
  for (std::size_t i = 0; i < areas.size(); ++i) Splitter(areas[i], borders, meshes[i]).split_all();
}

}  // namespace cairn
