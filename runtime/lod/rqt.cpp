// The method `rqt` (Intel 2012): triangulations worked out when the pack was baked, stored as one bit per
// visited vertex (`cairn bake --rqt`).
//
// A tile's flags are decoded when it is loaded. For a view each patch takes the coarsest triangulation whose
// error is within the tolerance at the distance of the patch's box (the formula after figure 3), and all
// samples where none is.
//
// Departures: the sample has one triangulation per patch and splits the patch into four until it is good
// enough. Here the scene decides which tiles there are, so each tile has eight triangulations, every one with
// twice the error of the one before, and a patch is 64×64 cells of a tile. The bound of the screen error
// holds up to the viewport's corners (ScreenErrorBudget). The tile's own error against finer tiles counts,
// and so does the distance of triangles from the bilinear surface between samples. Squares whose flat
// triangles leave the curved Earth by more than an eighth of the allowed error are split. A tile without
// flags is triangulated when it is loaded, from a 64th of its sample spacing on. Where patches take different
// triangulations, their border gets the vertices of both.
//
// Guarantee: that of the method `cairn`.

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <numbers>
#include <unordered_map>

#include "cairn/geodesy.h"
#include "format/rqt_block.h"
#include "format/rqt_triangulate.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/bisection_forest.h"
#include "runtime/lod/mesh/patches.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/surface/vertex_errors.h"
#include "runtime/view/screen_error_budget.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

constexpr int kStepsWithoutFlags = 8;
constexpr double kSpacingToTolerance = 1.0 / 64;
constexpr double kMaxSagittaShare = 1.0 / 8;
constexpr int kPatchCells = 64;

/// A tile's triangulations, and the sagitta of its cells.
struct Triangulated {
  RqtBlock block;
  double sagitta_m = 0;  ///< see sagitta_of_cell_m()
};

/// Returns the largest distance of a patch's triangles from the bilinear surface between samples.
double largest_twist_m(const LodScene& scene, const TileWindow& window, const Patch& patch) {
  std::int64_t worst = 0;
  for (int r = patch.row; r < patch.row + patch.cells; ++r) {
    for (int c = patch.column; c < patch.column + patch.cells; ++c) {
      const std::int64_t twist = std::int64_t{window.quanta(c, r)} - window.quanta(c + 1, r) -
                                 window.quanta(c, r + 1) + window.quanta(c + 1, r + 1);
      worst = std::max(worst, std::abs(twist));
    }
  }
  return static_cast<double>(worst) * scene.quantum_m / 4;
}

RqtBlock block_of(const LodScene& scene, const LodTile& tile) {
  const bool rising = root_rises(tile.source);
  if (tile.flags) {
    if (auto block = decode_rqt_block(*tile.flags, scene.tile_size, rising)) return std::move(*block);
  }
  const double spacing_m =
      scene.ellipsoid.equator_degree_m() * tile_width_degrees(tile.source.level) / (scene.tile_size - 1);
  const auto tolerance_m = static_cast<float>(spacing_m * kSpacingToTolerance);
  return {tolerance_m, kStepsWithoutFlags,
          triangulate(*tile.heights, scene.quantum_m, tolerance_m, kStepsWithoutFlags, rising)};
}

/// The triangulation that a patch takes.
struct Choice {
  int step = kMostRqtSteps - 1;  ///< of the tile's triangulations; -1 for all samples
  int coarsest = 16;  ///< squares of more than 2^coarsest cells are split for the Earth's curvature
};

/// Enables the vertices that the patches of one tile take.
class PatchSelection {
 public:
  PatchSelection(const RqtSteps& vertices, const TileWindow& window, std::size_t tile,
                 BisectionForest& forest)
      : vertices_(vertices),
        window_(window),
        tile_(tile),
        patch_level_(std::min(forest.levels(tile), std::countr_zero(static_cast<unsigned>(kPatchCells)))),
        across_(1 << (forest.levels(tile) - patch_level_)),
        choices_(static_cast<std::size_t>(across_) * static_cast<std::size_t>(across_)),
        forest_(forest) {}

  void set(const Patch& patch, const Choice& choice) {
    choices_[static_cast<std::size_t>((patch.row >> patch_level_) * across_ +
                                      (patch.column >> patch_level_))] = choice;
  }

  void run() {
    if (forest_.levels(tile_) > 0) within(forest_.levels(tile_), 0, 0);
  }

 private:
  // Returns the finest choice of the patches in a square.
  Choice choice_in(int k, int x, int y) const {
    const int up = std::max(0, k - patch_level_), down = std::max(0, patch_level_ - k);
    Choice finest;
    for (int j = (y << up) >> down; j < (1 << up) + ((y << up) >> down); ++j) {
      for (int i = (x << up) >> down; i < (1 << up) + ((x << up) >> down); ++i) {
        const Choice& one = choices_[static_cast<std::size_t>(j * across_ + i)];
        finest.step = std::min(finest.step, one.step);
        finest.coarsest = std::min(finest.coarsest, one.coarsest);
      }
    }
    return finest;
  }

  void within(int k, int x, int y) {
    const Choice choice = choice_in(k, x, y);
    const int h = 1 << (k - 1), c = (2 * x + 1) * h, r = (2 * y + 1) * h;
    const auto has = [&](int column, int row) {
      return k > choice.coarsest ||
             vertices_.has(window_.column() + column, window_.row() + row, choice.step);
    };
    if (!has(c, r)) return;
    forest_.enable_centre(tile_, k, x, y);
    if (has(c, r - h)) forest_.enable_middle(tile_, k, x, y, BisectionForest::south);
    if (has(c + h, r)) forest_.enable_middle(tile_, k, x, y, BisectionForest::east);
    if (has(c, r + h)) forest_.enable_middle(tile_, k, x, y, BisectionForest::north);
    if (has(c - h, r)) forest_.enable_middle(tile_, k, x, y, BisectionForest::west);
    for (int q = 0; k > 1 && q < 4; ++q) within(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1));
  }

  const RqtSteps& vertices_;
  const TileWindow& window_;
  std::size_t tile_;
  int patch_level_;
  int across_;
  std::vector<Choice> choices_;
  BisectionForest& forest_;
};

class Rqt : public LodMethod {
 public:
  void prepare(const LodScene& scene) override {
    std::unordered_map<TileId, Triangulated> kept;
    for (const LodTile& tile : scene.tiles) {
      if (kept.contains(tile.source)) continue;
      const auto known = kept_.find(tile.source);
      kept.emplace(tile.source, known != kept_.end() ? std::move(known->second) : load(scene, tile));
    }
    kept_ = std::move(kept);
    patches_.prepare(scene);
    prepare_twists(scene);
    forest_.prepare(scene);
  }

  std::uint64_t prepared_bytes() const override {
    std::uint64_t bytes = forest_.bytes() + patches_.bytes();
    for (const auto& [source, tile] : kept_) bytes += tile.block.vertices.all().size();
    for (const auto& [area, twists] : twists_m_) bytes += twists.size() * sizeof(double);
    return bytes;
  }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const auto select = [&] {
      const std::vector<std::size_t> drawn = tiles_in_view(scene, view);
      choose(scene, view, drawn);
      return drawn;
    };
    return mesh_of_forest(scene, forest_, select, [&](std::size_t i, LodMesh& mesh) {
      forest_.append(
          scene, i, BisectionForest::kNeverCull, [](int, int, int) { return true; }, mesh);
    });
  }

 private:
  static Triangulated load(const LodScene& scene, const LodTile& tile) {
    const double cell =
        tile_width_degrees(tile.source.level) / (scene.tile_size - 1) * std::numbers::pi / 180;
    return {block_of(scene, tile), sagitta_of_cell_m(cell, tile.max_m, scene.ellipsoid)};
  }

  void prepare_twists(const LodScene& scene) {
    std::unordered_map<TileId, std::vector<double>> kept;
    for (const LodTile& tile : scene.tiles) {
      const auto known = twists_m_.find(tile.area);
      if (known != twists_m_.end() && known->second.size() == patches_.of(tile).size()) {
        kept.emplace(tile.area, std::move(known->second));
        continue;
      }
      const TileWindow window(scene, tile);
      std::vector<double>& twists = kept[tile.area];
      for (const Patch& patch : patches_.of(tile)) twists.push_back(largest_twist_m(scene, window, patch));
    }
    twists_m_ = std::move(kept);
  }

  void choose(const LodScene& scene, const LodView& view, const std::vector<std::size_t>& drawn) {
    const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
    const ViewFrustum frustum(view.view, Occluder(scene.lowest_m, scene.ellipsoid));
    const glm::dvec3 eye = camera_frame(view.view).position;
    forest_.begin();
    for (const std::size_t i : drawn) {
      const LodTile& tile = scene.tiles[i];
      const Triangulated& own = kept_.at(tile.source);
      const std::vector<double>& twists_m = twists_m_.at(tile.area);
      const std::vector<Patch>& patches = patches_.of(tile);
      const TileWindow window(scene, tile);
      PatchSelection selection(own.block.vertices, window, i, forest_);
      for (std::size_t p = 0; p < patches.size(); ++p) {
        if (view.cull && !frustum.sees(patches[p].volume)) continue;
        const double between_m = tile.error_m > 0 ? tile.error_m + twists_m[p] : 0;
        const ScreenErrorBudget::ProjectedScale scale = budget.scale_from(patches[p].volume.distance_m(eye));
        selection.set(patches[p], choice_for(own, budget.error_m(scale, between_m, 0)));
      }
      selection.run();
    }
    forest_.join_corners();
  }

  static Choice choice_for(const Triangulated& own, double allowed_m) {
    Choice choice{-1, 1};
    while (choice.coarsest < 15 &&
           own.sagitta_m * static_cast<double>(std::uint64_t{4} << (2 * choice.coarsest)) <=
               allowed_m * kMaxSagittaShare)
      ++choice.coarsest;
    double error_m = static_cast<double>(own.block.tolerance_m);
    while (choice.step + 1 < own.block.steps && error_m <= allowed_m * (1 - kMaxSagittaShare)) {
      ++choice.step;
      error_m *= 2;
    }
    return choice;
  }

  std::unordered_map<TileId, Triangulated> kept_;
  Patches patches_{kPatchCells, 0};
  std::unordered_map<TileId, std::vector<double>> twists_m_;  ///< by area, then patch
  BisectionForest forest_;
};

}  // namespace

extern const LodMethodInfo rqt_lod_method;
const LodMethodInfo rqt_lod_method{"rqt", true, create_without_options<Rqt>};

}  // namespace cairn
