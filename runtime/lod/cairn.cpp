// The method `cairn`: the fewest triangles of the restricted quadtree triangulation that keep the tolerance.
//
// When a tile is loaded, every vertex of its bisection hierarchy gets the largest distance of the samples
// from the triangles that it would bisect (SquareErrors). For a view, a square requests the vertices whose
// triangles may exceed the tolerance. A requested vertex is added if the mesh comes to have the triangle that
// it bisects, with all vertices that it depends on (BisectionForest::refine()). Errors need not grow towards
// the coarse levels, as they must in SOAR, where a small cliff at the far end of a large square makes every
// square above it as bad. The largest error within a square only tells where not to descend.
//
// A bound over a square requests too much: it takes the worst sample to be at the worst place, and the
// Earth's curvature to be seen from the side. So a triangle is tested before it is bisected (TriangleError).
// Where squares are small on the screen, at fine tolerances, the test costs more than it saves and is
// skipped.
//
// What the hierarchy adds for its own sake, most of all along a step across its grid, is removed again where
// it is much of a tile's mesh (VertexDecimation).
//
// A vertical error is seen under the angle between the ray and the vertical: from above it hardly shows
// (ScreenErrorBudget).
//
// Guarantee: every finest sample in the viewport is within τ of its place on the screen, where the tiles' own
// error takes at most three quarters of τ; where it takes more, within that error and a quarter of τ. Along
// borders where a finer tile has vertices for which this one has no samples, remove_t_junctions() splits
// triangles of one cell, and the tile's error counts twice there. Where a tile stands for finer ones, its
// cells are drawn as two triangles; the quarter of a cell's twist by which these differ from its bilinear
// surface is not counted.
//
// docs/decisions.md has what each of these steps saved.

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "cairn/geodesy.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/bisection_forest.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/subtriangle_error_ranges.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod/mesh/triangle_error.h"
#include "runtime/lod/mesh/vertex_decimation.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {
namespace {

/// The exact test is skipped for squares whose side in pixels, times the square of the tolerance, is at most
/// kSkipTestBelow, at tolerances up to kMaxSkipTolerance_px: it would cost more than the triangles that it
/// saves.
constexpr double kMaxSkipTolerance_px = 1;
constexpr double kSkipTestBelow = 32;

/// The exact test is not skipped where the sagitta takes more than this fraction of the headroom, because
/// squares bound the curvature in the worst direction only.
constexpr double kMaxSagittaShare = 0.5;

/// A tile's mesh is decimated if at least this fraction of its vertices was not requested. With fewer, the
/// decimation takes about as long as the rest of the method.
constexpr double kDecimateAbove = 0.25;

/// What is worked out when a tile is loaded.
struct PreparedTile {
  PreparedTile(const LodScene& scene, const LodTile& tile, bool between_samples)
      : errors(scene, tile, between_samples),
        ranges(*tile.heights, tile.source, scene.quantum_m, between_samples) {}
  std::uint64_t bytes() const { return errors.bytes() + ranges.bytes(); }

  SquareErrors errors;
  SubtriangleErrorRanges ranges;
};

/// Requests the vertices of one tile's squares.
class VertexRequests {
 public:
  VertexRequests(const PreparedTile& prepared, const LodTile& tile, std::size_t number,
                 const TileWindow& window, const ScreenErrorBudget& budget, bool cull,
                 BisectionForest& forest)
      : errors_(prepared.errors),
        tile_(tile),
        number_(number),
        column_(window.column()),
        row_(window.row()),
        budget_(budget),
        cull_(cull),
        forest_(forest) {}

  /// Marks the vertices that this square of the window needs. Returns true if the squares within it need no
  /// call of their own.
  bool select(int k, int x, int y) const {
    x += column_ >> k, y += row_ >> k;
    const SquareSphere sphere = errors_.sphere(k, x, y);
    if (cull_ && !budget_.may_be_visible(sphere)) return true;
    const int middle = 1 << (k - 1);
    const ScreenErrorBudget::ProjectedScale scale =
        budget_.scale_of(sphere, errors_.positions().up_at((x << k) + middle, (y << k) + middle));
    const ScreenErrorBudget::Headroom headroom = budget_.headroom_of(scale);
    const bool needs_descent = k > SquareErrors::kSphereLevel && !scale.is_small;
    Limits limits;
    for (int j = k; j >= (needs_descent ? k : 1); --j) limits.of(j) = limit(scale, headroom, j);
    if (!needs_descent) {
      request_within(k, x, y, limits);
      return true;
    }
    if (errors_.at(k, x, y).max_within <= limits.of(k).centre) return true;
    request(k, x, y, limits.of(k));
    return false;
  }

 private:
  /// The largest allowed errors of a level's squares, as codes of SquareErrors.
  struct Limit {
    int centre;
    int middle;
    bool skips_exact_test;  ///< vertices beyond the limit are added without a test
  };
  struct Limits {
    Limit& of(int k) { return by_level[static_cast<std::size_t>(k)]; }
    const Limit& of(int k) const { return by_level[static_cast<std::size_t>(k)]; }

    std::array<Limit, 16> by_level;
  };

  Limit limit(const ScreenErrorBudget::ProjectedScale& scale, const ScreenErrorBudget::Headroom& headroom,
              int k) const {
    const double sagitta_m = errors_.sagitta_m(k);
    const auto code = [&](double chord) {
      return encode_rounding_down(
          static_cast<float>(ScreenErrorBudget::error_m(headroom, tile_.error_m, chord)));
    };
    return {code(sagitta_m), code(sagitta_m / 2),
            is_small(scale, k) && sagitta_m * headroom.per_sagitta <= kMaxSagittaShare * headroom.all_m};
  }

  bool is_small(const ScreenErrorBudget::ProjectedScale& scale, int k) const {
    const double tolerance_px = budget_.tolerance_px();
    if (tolerance_px > kMaxSkipTolerance_px) return false;
    const double side_m = (1 << k) * errors_.cell_m();
    return side_m * scale.any_px * tolerance_px * tolerance_px <= kSkipTestBelow * scale.depth_m;
  }

  void request_within(int k, int x, int y, const Limits& limits) const {
    if (errors_.at(k, x, y).max_within <= limits.of(k).centre) return;
    request(k, x, y, limits.of(k));
    for (int q = 0; k > 1 && q < 4; ++q) request_within(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1), limits);
  }

  void request(int k, int x, int y, const Limit& limit) const {
    const SquareError& square = errors_.at(k, x, y);
    const int column = x - (column_ >> k), row = y - (row_ >> k);
    if (limit.skips_exact_test) forest_.skip_exact_test(number_, k, column, row);
    if (square.centre > limit.centre) forest_.request_centre(number_, k, column, row);
    for (unsigned side = 0; side < 4; ++side) {
      if (square.middles[side] > limit.middle)
        forest_.request_middle(number_, k, column, row, static_cast<BisectionForest::Side>(side));
    }
  }

  const SquareErrors& errors_;
  const LodTile& tile_;
  std::size_t number_;
  int column_;
  int row_;
  const ScreenErrorBudget& budget_;
  bool cull_;
  BisectionForest& forest_;
};

class Cairn : public LodMethod {
 public:
  void prepare(const LodScene& scene) override {
    prepared_.prepare(scene);
    forest_.prepare(scene);
    tiles_.clear();
    for (const LodTile& tile : scene.tiles) tiles_.push_back({&prepared_.of(tile), TileWindow(scene, tile)});
  }
  std::uint64_t prepared_bytes() const override { return prepared_.bytes() + forest_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
    const auto select = [&] {
      const std::vector<std::size_t> drawn = tiles_in_view(scene, view);
      forest_.begin();
      bisect(scene, view, budget, drawn);
      return drawn;
    };
    VertexDecimation decimation(budget);
    return mesh_of_forest(scene, forest_, select, [&](std::size_t i, LodMesh& mesh) {
      append(scene, view, budget, i, decimation, mesh);
    });
  }

 private:
  void bisect(const LodScene& scene, const LodView& view, const ScreenErrorBudget& budget,
              const std::vector<std::size_t>& drawn) {
    std::vector<std::optional<VertexRequests>> requests(scene.tiles.size());
    for (const std::size_t i : drawn) {
      requests[i].emplace(*tiles_[i].prepared, scene.tiles[i], i, tiles_[i].window, budget, view.cull,
                          forest_);
    }
    const auto select = [&](std::size_t i, int k, int x, int y) {
      return !requests[i] || requests[i]->select(k, x, y);
    };
    const TriangleError error(view, scene.lowest_m);
    forest_.refine(select, [&](std::size_t i, const BisectionForest::Triangle& triangle) {
      const LodTile& tile = scene.tiles[i];
      const auto& [prepared, window] = tiles_[i];
      BisectionForest::Triangle samples = triangle;
      for (auto& [column, row] : samples) column += window.column(), row += window.row();
      return error.exceeds({*tile.heights, scene.quantum_m, prepared->errors, prepared->ranges, tile.error_m},
                           samples);
    });
  }

  void append(const LodScene& scene, const LodView& view, const ScreenErrorBudget& budget, std::size_t i,
              VertexDecimation& decimation, LodMesh& mesh) {
    const SquareErrors& errors = tiles_[i].prepared->errors;
    const TileWindow& window = tiles_[i].window;
    const std::size_t tiles = mesh.tiles.size();
    const double dependent = forest_.append(
        scene, i, view.cull ? SquareErrors::kSphereLevel : BisectionForest::kNeverCull,
        [&](int k, int x, int y) {
          return budget.may_be_visible(errors.sphere(k, x + (window.column() >> k), y + (window.row() >> k)));
        },
        mesh);
    const bool is_drawn = mesh.tiles.size() > tiles;
    if (is_drawn && dependent >= kDecimateAbove && can_decimate(scene, i))
      decimation.decimate({window, errors, scene.quantum_m}, mesh.tiles.back());
  }

  /// Decimation measures samples only, and must not remove vertices at which remove_t_junctions() will split.
  bool can_decimate(const LodScene& scene, std::size_t i) const {
    return scene.tiles[i].error_m <= 0 && forest_.has_finer_neighbour()[i] == 0;
  }

  /// A tile of the scene, by its index there.
  struct Tile {
    const PreparedTile* prepared;
    TileWindow window;
  };

  PreparedTiles<PreparedTile> prepared_;
  std::vector<Tile> tiles_;
  BisectionForest forest_;
};

}  // namespace

extern const LodMethodInfo cairn_lod_method;
const LodMethodInfo cairn_lod_method{"cairn", true, create_without_options<Cairn>};

}  // namespace cairn
