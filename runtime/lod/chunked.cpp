// The method `chunked` (Ulrich 2002, reference 3 of Intel 2012).
//
// A tile is a quadtree of chunks: the tile itself, its quarters, and so on down to 1,024 leaves. Each chunk
// is a static mesh, made when the tile is loaded, whose largest vertical error δ is half of that of the chunk
// above it. For a view a chunk is drawn if its δ projects to at most the tolerance at the distance of its box
// (ρ = δK/D), and is replaced by its four quarters otherwise. So a frame's work is a few comparisons per
// chunk; nothing is done per vertex. Chunks of one level agree along their rims, because they are parts of
// one triangulation; between levels upright ribbons join them (the paper has these, flanges and skirts to
// choose from). A skirt has free lower edges, so that it could not be told from a crack.
//
// Departures: leaves have every sample (δ = 0), because the finest δ of the paper is the least error that it
// can draw. The other meshes are restricted quadtree triangulations, as the paper's, but with δ the distance
// of every sample from the mesh and not that of the removed vertices. The bound of the screen error holds up
// to the viewport's corners (ScreenErrorBudget). A chunk of more than 65,536 vertices, which 16-bit indices
// cannot number, is always replaced by its quarters. Squares whose flat triangles leave the curved Earth by
// more than an eighth of δ are split. The paper's morphing of vertices towards the coarser chunk is left out.
//
// Guarantee: every finest sample in the viewport is within the tolerance, as far as the tiles' own error
// allows.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "cairn/geodesy.h"
#include "format/rqt_triangulate.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/remove_t_junctions.h"
#include "runtime/lod/mesh/rim_ribbons.h"
#include "runtime/lod/mesh/square_volumes.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/surface/vertex_errors.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/view/screen_error_budget.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

/// The levels of chunks above the leaves: a tile has 4^kChunkLevels leaves, or as many as have at least
/// 2^kLeastLeaf cells along a side.
constexpr int kChunkLevels = 5;
constexpr int kLeastLeaf = 2;
/// δ of the chunks just above the leaves, as a part of the sample spacing.
constexpr double kSpacingToDelta = 1.0 / 16;
constexpr double kMaxChordShare = 1.0 / 8;
constexpr std::size_t kMostChunkVertices = 65536;

/// A sample, counted from the chunk's south-west corner.
struct ChunkVertex {
  std::uint16_t column = 0;
  std::uint16_t row = 0;
};

struct ChunkMesh {
  std::vector<ChunkVertex> vertices;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  std::array<std::vector<std::uint16_t>, 4> rims;  ///< of the south, east, north and west side, ascending

  std::uint64_t bytes() const {
    std::uint64_t bytes = vertices.size() * sizeof(ChunkVertex) + triangles.size() * sizeof(triangles[0]);
    for (const auto& rim : rims) bytes += rim.size() * sizeof(rim[0]);
    return bytes;
  }
};

/// Makes the mesh of a square by bisecting triangles at the vertices for which has(column, row) is true.
template <class Has>
class ChunkMesher {
 public:
  ChunkMesher(int cells, const Has& has)
      : cells_(cells),
        has_(has),
        numbers_((static_cast<std::size_t>(cells) + 1) * (static_cast<std::size_t>(cells) + 1), kNone) {}

  /// Returns nullopt if there are too many vertices. `rises` says that the square's diagonal runs from
  /// south-west to north-east.
  std::optional<ChunkMesh> run(bool rises) {
    const Place sw{0, 0}, se{cells_, 0}, ne{cells_, cells_}, nw{0, cells_};
    if (rises) {
      bisect(ne, sw, se);
      bisect(sw, ne, nw);
    } else {
      bisect(se, nw, sw);
      bisect(nw, se, ne);
    }
    if (mesh_.vertices.size() > kMostChunkVertices) return std::nullopt;
    add_rims();
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Place {
    int c;
    int r;
  };

  // The triangle's right angle is at `apex`; the corners are anticlockwise.
  void bisect(const Place& from, const Place& to, const Place& apex) {
    const int c = from.c + to.c, r = from.r + to.r;
    const Place base{c / 2, r / 2};
    if (((c | r) & 1) == 0 && has_(base.c, base.r)) {
      bisect(apex, from, base);
      bisect(to, apex, base);
    } else {
      mesh_.triangles.push_back({number(from), number(to), number(apex)});
    }
  }

  std::uint16_t number(const Place& at) {
    std::uint32_t& n = numbers_[static_cast<std::size_t>(at.r) * (static_cast<std::size_t>(cells_) + 1) +
                                static_cast<std::size_t>(at.c)];
    if (n == kNone) {
      n = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back({static_cast<std::uint16_t>(at.c), static_cast<std::uint16_t>(at.r)});
    }
    return static_cast<std::uint16_t>(n);
  }

  void add_rims() {
    const auto add = [&](std::size_t side, int c, int r) {
      const std::uint32_t n = numbers_[static_cast<std::size_t>(r) * (static_cast<std::size_t>(cells_) + 1) +
                                       static_cast<std::size_t>(c)];
      if (n != kNone) mesh_.rims[side].push_back(static_cast<std::uint16_t>(n));
    };
    for (int i = 0; i <= cells_; ++i) {
      add(0, i, 0);
      add(1, cells_, i);
      add(2, i, cells_);
      add(3, 0, i);
    }
  }

  int cells_;
  const Has& has_;
  std::vector<std::uint32_t> numbers_;
  ChunkMesh mesh_;
};

template <class Has>
std::optional<ChunkMesh> mesh_of_square(int cells, bool rises, const Has& has) {
  return ChunkMesher<Has>(cells, has).run(rises);
}

/// A chunk above the leaves has a mesh of its own; a leaf draws every sample.
struct Chunk {
  std::optional<ChunkMesh> mesh;
  double twist_m = 0;  ///< the largest distance of its cells' triangles from their bilinear surfaces
};

/// The chunks of a tile.
class ChunkTree {
 public:
  ChunkTree(const LodScene& scene, const LodTile& tile, bool)
      : volumes_(scene, tile, std::max(kLeastLeaf, levels_of(tile) - kChunkLevels)),
        chunk_levels_(volumes_.levels() - volumes_.least()) {
    for (int j = 0; j <= chunk_levels_; ++j) {
      chunks_.emplace_back(std::size_t{1} << (2 * (chunk_levels_ - j)));
      for (int y = 0; y < across(j); ++y) {
        for (int x = 0; x < across(j); ++x)
          chunk(j, x, y).twist_m =
              j == 0 ? twist_of_leaf(*tile.heights, x, y) * scene.quantum_m / 4 : twist_of_quarters(j, x, y);
      }
    }
    if (chunk_levels_ > 0) triangulate_chunks(scene, tile);
  }

  int leaf_level() const { return volumes_.least(); }  ///< log2 of a leaf's cells
  /// Level 0 has the leaves; (x, y) counts chunks from the tile's south-west corner.
  const Chunk& at(int j, int x, int y) const { return chunks_[static_cast<std::size_t>(j)][slot(j, x, y)]; }
  const BoundingVolume& volume(int j, int x, int y) const {
    return volumes_.at(leaf_level() + j, x, y).volume;
  }
  double error_m(int j) const { return errors_m_[static_cast<std::size_t>(j)]; }

  std::uint64_t bytes() const {
    std::uint64_t bytes = volumes_.bytes();
    for (const auto& level : chunks_) {
      for (const Chunk& chunk : level) bytes += sizeof(Chunk) + (chunk.mesh ? chunk.mesh->bytes() : 0);
    }
    return bytes;
  }

 private:
  static int levels_of(const LodTile& tile) {
    return std::bit_width(static_cast<unsigned>(tile.heights->size - 1)) - 1;
  }
  int across(int j) const { return 1 << (chunk_levels_ - j); }
  std::size_t slot(int j, int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(across(j)) + static_cast<std::size_t>(x);
  }
  Chunk& chunk(int j, int x, int y) { return chunks_[static_cast<std::size_t>(j)][slot(j, x, y)]; }
  int cells(int j) const { return 1 << (leaf_level() + j); }

  double twist_of_leaf(const HeightTile& heights, int x, int y) const {
    const int n = cells(0);
    std::int64_t twist = 0;
    for (int r = y * n; r < (y + 1) * n; ++r) {
      for (int c = x * n; c < (x + 1) * n; ++c) {
        twist = std::max(twist, std::abs(std::int64_t{heights.at(c, r)} - heights.at(c + 1, r) -
                                         heights.at(c, r + 1) + heights.at(c + 1, r + 1)));
      }
    }
    return static_cast<double>(twist);
  }

  double twist_of_quarters(int j, int x, int y) const {
    double twist_m = 0;
    for (int q = 0; q < 4; ++q)
      twist_m = std::max(twist_m, at(j - 1, 2 * x + (q & 1), 2 * y + (q >> 1)).twist_m);
    return twist_m;
  }

  void triangulate_chunks(const LodScene& scene, const LodTile& tile) {
    const double cell_deg = tile_width_degrees(tile.source.level) / (tile.heights->size - 1);
    const auto delta_m = static_cast<float>(cell_deg * scene.ellipsoid.equator_degree_m() * kSpacingToDelta);
    const bool rising = root_rises(tile.source);
    const RqtSteps steps = triangulate(*tile.heights, scene.quantum_m, delta_m, chunk_levels_, rising);
    errors_m_.assign(1, 0);
    for (int j = 1; j <= chunk_levels_; ++j) {
      const double delta = std::ldexp(static_cast<double>(delta_m), j - 1);
      const int coarsest = coarsest_square(cell_deg * std::numbers::pi / 180, delta, scene.ellipsoid);
      errors_m_.push_back(delta + chord_m(cell_deg * std::numbers::pi / 180, coarsest, scene.ellipsoid));
      for (int y = 0; y < across(j); ++y) {
        for (int x = 0; x < across(j); ++x) {
          const int west = x * cells(j), south = y * cells(j);
          chunk(j, x, y).mesh = mesh_of_square(
              cells(j), diagonal_rises(rising, tile.heights->size, west, south, cells(j)), [&](int c, int r) {
                const int both = (west + c) | (south + r);
                return (both & -both) >= 1 << coarsest || steps.has(west + c, south + r, j - 1);
              });
        }
      }
    }
  }

  /// Returns how far a flat triangle of a square of 2^k cells may be from the curved surface that has its
  /// heights: SquareErrors::sagitta_m().
  double chord_m(double cell, int k, const Ellipsoid& ellipsoid) const {
    constexpr double kLean = 0.39 * std::numbers::sqrt2;
    const double side = std::ldexp(1.0, k);
    const SquareVolume& all = volumes_.at(volumes_.levels(), 0, 0);
    return sagitta_of_cell_m(cell, all.high_m, ellipsoid) * side * side +
           kLean * (all.high_m - all.low_m) * side * cell;
  }

  int coarsest_square(double cell, double delta_m, const Ellipsoid& ellipsoid) const {
    int k = 1;
    while (k < volumes_.levels() && chord_m(cell, k + 1, ellipsoid) <= kMaxChordShare * delta_m) ++k;
    return k;
  }

  SquareVolumes volumes_;
  int chunk_levels_;
  std::vector<std::vector<Chunk>> chunks_;
  std::vector<double> errors_m_;  ///< by level
};

/// A chunk to draw, or the whole of a window that is smaller than a leaf.
struct ChosenChunk {
  std::size_t tile = 0;  ///< in the scene
  const ChunkMesh* mesh = nullptr;
  int column = 0;  ///< of its south-west sample, in the tile's window
  int row = 0;
};

class Chunked : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { trees_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return trees_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const double start = thread_cpu_s();
    const std::vector<ChosenChunk> chosen = choose(scene, view);
    const double selected = thread_cpu_s();
    LodMesh mesh;
    const std::vector<Placed> placed = append(scene, chosen, mesh);
    unify_border_heights(scene, mesh);
    join(chosen, placed, mesh);
    mesh.count(IndexForm::list, {3 * mesh.triangle_count(), chosen.size()});
    mesh.selection_s = selected - start;
    mesh.building_s = thread_cpu_s() - selected;
    return mesh;
  }

 private:
  /// Where a chunk's vertices are in a mesh.
  struct Placed {
    std::size_t tile = 0;  ///< in LodMesh::tiles
    std::size_t first = 0;
  };

  std::vector<ChosenChunk> choose(const LodScene& scene, const LodView& view) {
    const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
    const ViewFrustum frustum(view.view, Occluder(scene.lowest_m, scene.ellipsoid));
    const glm::dvec3 eye = camera_frame(view.view).position;
    std::vector<ChosenChunk> chosen;
    for (const std::size_t i : tiles_in_view(scene, view)) {
      const LodTile& tile = scene.tiles[i];
      const ChunkTree& tree = trees_.of(tile);
      const TileWindow window(scene, tile);
      const int level = std::bit_width(static_cast<unsigned>(window.cells())) - 1, leaf = tree.leaf_level();
      const auto draw_all = [&](int k, int column, int row) {
        const bool rises = diagonal_rises(root_rises(tile.source), scene.tile_size, window.column() + column,
                                          window.row() + row, 1 << k);
        chosen.push_back({i, &every_sample(1 << k, rises), column, row});
      };
      if (level < leaf) {
        draw_all(level, 0, 0);
        continue;
      }
      const auto visit = [&](auto self, int j, int x, int y) -> void {
        const Chunk& chunk = tree.at(j, x, y);
        const BoundingVolume& volume = tree.volume(j, x, y);
        if (view.cull && !frustum.sees(volume)) return;
        const int column = (x << (leaf + j)) - window.column(), row = (y << (leaf + j)) - window.row();
        if (j == 0) return draw_all(leaf, column, row);
        const double between_m = tile.error_m > 0 ? tile.error_m + chunk.twist_m : 0;
        const double allowed_m = budget.error_m(budget.scale_from(volume.distance_m(eye)), between_m, 0);
        if (chunk.mesh && tree.error_m(j) <= allowed_m) {
          chosen.push_back({i, &*chunk.mesh, column, row});
        } else {
          for (int q = 0; q < 4; ++q) self(self, j - 1, 2 * x + (q & 1), 2 * y + (q >> 1));
        }
      };
      visit(visit, level - leaf, window.column() >> level, window.row() >> level);
    }
    return chosen;
  }

  /// The leaves' meshes, of which there are two for each size at most.
  const ChunkMesh& every_sample(int cells, bool rises) {
    std::optional<ChunkMesh>& made = leaves_[{cells, rises}];
    if (!made) made = mesh_of_square(cells, rises, [](int, int) { return true; });
    return *made;
  }

  static std::vector<Placed> append(const LodScene& scene, const std::vector<ChosenChunk>& chosen,
                                    LodMesh& mesh) {
    std::vector<Placed> placed;
    for (const ChosenChunk& chunk : chosen) {
      if (mesh.tiles.empty() || mesh.tiles.back().tile != chunk.tile)
        mesh.tiles.push_back({chunk.tile, {}, {}});
      LodTileMesh& out = mesh.tiles.back();
      const TileWindow window(scene, scene.tiles[chunk.tile]);
      const auto first = static_cast<std::uint32_t>(out.vertices.size());
      placed.push_back({mesh.tiles.size() - 1, first});
      for (const ChunkVertex& v : chunk.mesh->vertices)
        out.vertices.push_back(window.vertex(chunk.column + v.column, chunk.row + v.row));
      for (const auto& t : chunk.mesh->triangles)
        out.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return placed;
  }

  static void join(const std::vector<ChosenChunk>& chosen, const std::vector<Placed>& placed, LodMesh& mesh) {
    RimRibbons ribbons;
    std::vector<LodVertex> rim;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const std::vector<LodVertex>& vertices = mesh.tiles[placed[i].tile].vertices;
      for (std::size_t side = 0; side < 4; ++side) {
        rim.clear();
        for (const std::uint16_t n : chosen[i].mesh->rims[side]) rim.push_back(vertices[placed[i].first + n]);
        ribbons.add(side % 2 == 1, side == 0 || side == 3 ? RimRibbons::above : RimRibbons::below, rim);
      }
    }
    ribbons.append_to(mesh.walls);
  }

  PreparedTiles<ChunkTree> trees_;
  std::map<std::pair<int, bool>, std::optional<ChunkMesh>> leaves_;
};

}  // namespace

extern const LodMethodInfo chunked_lod_method;
const LodMethodInfo chunked_lod_method{"chunked", true, create_without_options<Chunked>};

}  // namespace cairn
