// Our own: the fewest triangles of the restricted quadtree triangulation that keep the tolerance.
//
// When a tile is loaded, every vertex of its bisection hierarchy gets the largest distance of the samples
// from the triangles that it would bisect (SquareErrors). A picture wants the vertices whose triangles it may
// see off by more than the tolerance, and of these takes the ones that bisect a triangle which the mesh comes
// to have, with those that they need (BisectionForest::settle): errors need not grow towards the coarse as
// SOAR's have to, where a fine cliff at the far end of a large square makes all that is above it as bad. The
// largest error within a square only says where not to look.
//
// A bound over a square asks for too much: of a triangle it takes the worst sample to be at the worst place,
// and the Earth's curvature to be seen from the side. So a triangle is looked into before it is bisected: in
// ten parts, of each of which is known where its samples lie above and below the triangle
// (SubtriangleErrorRanges), and sample by sample where it is small or few of its parts are in doubt
// (TriangleError). Squares are bounded only as the mesh comes to have triangles in them. Where they are small
// on the picture of a fine tolerance, looking costs more than it saves, and what they ask for is taken.
//
// What the hierarchy adds for its own sake, most of all along a step across its grid, is taken out again
// where it is much of a tile's mesh (VertexDecimation).
//
// A vertical error is seen under the angle between the ray and the vertical: looking down it hardly shows
// (ScreenErrorBudget).
//
// Promise: every finest sample in the picture is within τ of its place on the screen, where the tiles' own
// error takes at most three quarters of τ; where it takes more, within that and a quarter of τ. Along borders
// where a finer tile has vertices that this one has no samples for, remove_t_junctions() splits triangles of
// one cell: there the tile's error counts twice. Where a tile stands for finer ones, its cells are drawn as
// two triangles: the quarter of a cell's twist by which these differ from its bilinear surface is not mended.
//
// Measured beside it was the same hierarchy with errors and spheres grown towards the coarse, which is the
// method `soar`: about as many triangles where the eye looks ahead and twice as many where it looks down.
// Here a square whose scale hardly changes is projected once for all within it, and what follows compares
// whole numbers. Spheres of 8 and 16 cells instead of 4 took more triangles for about the same time.

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/bisection_forest.h"
#include "runtime/lod/mesh/cpu_clock.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/remove_t_junctions.h"
#include "runtime/lod/mesh/screen_error_budget.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/subtriangle_error_ranges.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod/mesh/triangle_error.h"
#include "runtime/lod/mesh/vertex_decimation.h"
#include "cairn/geodesy.h"

namespace cairn {
namespace {

/// Tolerances up to a pixel make meshes of small squares. What these want is taken without a look where their
/// side, in pixels, times the tolerance's square is no more than this: a look would cost more than the
/// triangles that it saves, which are 2 to 15 % in the low flights, for 8 to 33 % of the time.
constexpr double kFine_px = 1;
constexpr double kSkipTestBelow = 32;

/// And where the Earth's curvature, which squares know in the worst direction only, takes no more than this
/// share of what is allowed.
constexpr double kMaxSagittaShare = 0.5;

/// A tile's mesh is thinned out where so much of it is there for the hierarchy's sake. Elsewhere that takes
/// as long as the rest of the method, or longer.
constexpr double kThinned = 0.25;

/// What is known of a tile.
struct Known {
  Known(const LodScene& scene, const LodTile& tile, bool between_samples)
      : errors(scene, tile, between_samples),
        ranges(*tile.heights, tile.source, scene.quantum_m, between_samples) {}
  std::uint64_t bytes() const { return errors.bytes() + ranges.bytes(); }

  SquareErrors errors;
  SubtriangleErrorRanges ranges;
};

/// Says what one tile's squares ask for.
class Selection {
 public:
  Selection(const Known& known, const LodTile& tile, std::size_t number, const TileWindow& window,
            const ScreenErrorBudget& allowance, bool cull, BisectionForest& forest)
      : errors_(known.errors),
        tile_(tile),
        number_(number),
        column_(window.column()),
        row_(window.row()),
        allowance_(allowance),
        cull_(cull),
        forest_(forest) {}

  /// Of a square of the window: wants what it wants. True if that settles all within it, too.
  bool select(int k, int x, int y) const {
    x += column_ >> k, y += row_ >> k;
    const SquareSphere sphere = errors_.sphere(k, x, y);
    if (cull_ && !allowance_.sees(sphere)) return true;
    const int middle = 1 << (k - 1);
    const ScreenErrorBudget::Scale scale =
        allowance_.scale_of(sphere, errors_.positions().up_at((x << k) + middle, (y << k) + middle));
    const ScreenErrorBudget::Room room = allowance_.room_of(scale);
    const bool alone = k > SquareErrors::kSphereLevel && !scale.is_small;
    Limits limits;
    for (int j = k; j >= (alone ? k : 1); --j) limits.of(j) = limit(scale, room, j);
    if (!alone) {
      want_within(k, x, y, limits);
      return true;
    }
    if (errors_.at(k, x, y).below <= limits.of(k).centre) return true;
    want(k, x, y, limits.of(k));
    return false;
  }

 private:
  /// Of a level's squares: what errors they may have.
  struct Limit {
    int centre;
    int middle;
    bool is_trusted;  ///< what is wanted beyond is taken without a look
  };
  struct Limits {
    Limit& of(int k) { return by_level[static_cast<std::size_t>(k)]; }
    const Limit& of(int k) const { return by_level[static_cast<std::size_t>(k)]; }

    std::array<Limit, 16> by_level;
  };

  Limit limit(const ScreenErrorBudget::Scale& scale, const ScreenErrorBudget::Room& room, int k) const {
    const double chord_m = errors_.chord_m(k);
    const auto code = [&](double chord) {
      return round_down(static_cast<float>(ScreenErrorBudget::error_m(room, tile_.error_m, chord)));
    };
    return {code(chord_m), code(chord_m / 2),
            is_small(scale, k) && chord_m * room.per_chord <= kMaxSagittaShare * room.all_m};
  }

  bool is_small(const ScreenErrorBudget::Scale& scale, int k) const {
    const double tolerance_px = allowance_.tolerance_px();
    if (tolerance_px > kFine_px) return false;
    const double side_m = (1 << k) * errors_.cell_radians() * kEquatorialRadius;
    return side_m * scale.any_px * tolerance_px * tolerance_px <= kSkipTestBelow * scale.depth_m;
  }

  void want_within(int k, int x, int y, const Limits& limits) const {
    if (errors_.at(k, x, y).below <= limits.of(k).centre) return;
    want(k, x, y, limits.of(k));
    for (int q = 0; k > 1 && q < 4; ++q) want_within(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1), limits);
  }

  void want(int k, int x, int y, const Limit& limit) const {
    const SquareError& square = errors_.at(k, x, y);
    const int column = x - (column_ >> k), row = y - (row_ >> k);
    if (limit.is_trusted) forest_.trust(number_, k, column, row);
    if (square.centre > limit.centre) forest_.want_centre(number_, k, column, row);
    for (unsigned side = 0; side < 4; ++side) {
      if (square.middles[side] > limit.middle)
        forest_.want_middle(number_, k, column, row, static_cast<BisectionForest::Side>(side));
    }
  }

  const SquareErrors& errors_;
  const LodTile& tile_;
  std::size_t number_;
  int column_;
  int row_;
  const ScreenErrorBudget& allowance_;
  bool cull_;
  BisectionForest& forest_;
};

class Cairn : public LodMethod {
 public:
  void prepare(const LodScene& scene) override {
    known_.prepare(scene);
    forest_.prepare(scene);
    tiles_.clear();
    for (const LodTile& tile : scene.tiles) tiles_.push_back({&known_.of(tile), TileWindow(scene, tile)});
  }
  std::uint64_t prepared_bytes() const override { return known_.bytes() + forest_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const double start = thread_cpu_s();
    const ScreenErrorBudget allowance(view, scene.lowest_m);
    const std::vector<std::size_t> drawn = tiles_in_view(scene, view);
    forest_.begin();
    bisect(scene, view, allowance, drawn);
    const double selected = thread_cpu_s();
    LodMesh mesh;
    VertexDecimation thinning(allowance);
    for (const std::size_t i : drawn) append(scene, view, allowance, i, thinning, mesh);
    remove_t_junctions(scene, forest_.meet_finer(), mesh);
    mesh.count(IndexForm::list, {3 * mesh.triangle_count(), mesh.tiles.size()});
    mesh.selection_s = selected - start;
    mesh.building_s = thread_cpu_s() - selected;
    return mesh;
  }

 private:
  void bisect(const LodScene& scene, const LodView& view, const ScreenErrorBudget& allowance,
              const std::vector<std::size_t>& drawn) {
    std::vector<std::optional<Selection>> selections(scene.tiles.size());
    for (const std::size_t i : drawn) {
      selections[i].emplace(*tiles_[i].known, scene.tiles[i], i, tiles_[i].window, allowance, view.cull,
                            forest_);
    }
    const auto select = [&](std::size_t i, int k, int x, int y) {
      return !selections[i] || selections[i]->select(k, x, y);
    };
    const TriangleError error(view, scene.lowest_m);
    forest_.settle(select, [&](std::size_t i, const BisectionForest::Triangle& triangle) {
      const LodTile& tile = scene.tiles[i];
      const auto& [known, window] = tiles_[i];
      BisectionForest::Triangle samples = triangle;
      for (auto& [column, row] : samples) column += window.column(), row += window.row();
      return error.exceeds({*tile.heights, scene.quantum_m, known->errors, known->ranges, tile.error_m},
                           samples);
    });
  }

  void append(const LodScene& scene, const LodView& view, const ScreenErrorBudget& allowance, std::size_t i,
              VertexDecimation& thinning, LodMesh& mesh) {
    const SquareErrors& errors = tiles_[i].known->errors;
    const TileWindow& window = tiles_[i].window;
    const std::size_t tiles = mesh.tiles.size();
    const double unwanted = forest_.append(
        scene, i, view.cull ? SquareErrors::kSphereLevel : BisectionForest::kNeverCull,
        [&](int k, int x, int y) {
          return allowance.sees(errors.sphere(k, x + (window.column() >> k), y + (window.row() >> k)));
        },
        mesh);
    const bool is_drawn = mesh.tiles.size() > tiles;
    if (is_drawn && unwanted >= kThinned && is_thinnable(scene, i))
      thinning.thin({window, errors, scene.quantum_m}, mesh.tiles.back());
  }

  /// Not where places between samples count, or where remove_t_junctions() has yet to split triangles.
  bool is_thinnable(const LodScene& scene, std::size_t i) const {
    return scene.tiles[i].error_m <= 0 && forest_.meet_finer()[i] == 0;
  }

  /// Of a tile of the scene, by its number there.
  struct Tile {
    const Known* known;
    TileWindow window;
  };

  PreparedTiles<Known> known_;
  std::vector<Tile> tiles_;
  BisectionForest forest_;
};

}  // namespace

extern const LodMethodInfo cairn_lod_method;
const LodMethodInfo cairn_lod_method{
    "cairn", true, [](const LodOptions&) -> std::unique_ptr<LodMethod> { return std::make_unique<Cairn>(); }};

}  // namespace cairn
