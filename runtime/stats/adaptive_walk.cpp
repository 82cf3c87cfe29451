#include "runtime/stats/adaptive_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "runtime/paging/tile_selection.h"

namespace cairn {
namespace {

ViewState view_over(const TileId& eye, const Move& move, const TileAvailability& contents) {
  const GeoBounds b = tile_bounds(eye);
  ViewState view;
  view.ellipsoid = contents.pack().header().body.shape;
  view.eye = {b.west + b.width() / 2, b.south + b.height() / 2};
  const double pixel = pixel_footprint_m(view, 1);
  const double above_m = sample_width_m(eye.level, contents.pack().header()) / pixel;
  view.height_m = contents.ceiling_m(view.eye) + above_m;
  view.heading_deg = std::atan2(move.dx, move.dy) * 180 / std::numbers::pi;
  view.pitch_deg = -10;
  return view;
}

std::vector<TileId> counted(const TileCut& cut, int coarsest) {
  std::vector<TileId> tiles;
  for (const CutNode& node : cut) {
    if (node.heights && node.heights->id.level >= coarsest) tiles.push_back(node.heights->id);
  }
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

}  // namespace

AdaptiveWalk walk_adaptively(const AdaptiveSpec& spec, std::span<const Move> walk,
                             const std::shared_ptr<const PackReader>& pack) {
  const TileAvailability contents(pack);
  const Occluder occluder(contents.lowest_m(), pack->header().body.shape);
  const TileTree tree(contents, occluder);
  FocusTile focus(FocusTile::kTileMargin, FocusTile::kLevelMargin);
  SelectionRules rules{kTileShare * spec.tolerance_px, std::numeric_limits<double>::infinity(),
                       std::exp2(FocusTile::kLevelMargin)};
  if (spec.budget_bytes > 0) rules.budget_bytes = spec.budget_bytes;
  AdaptiveWalk result;
  TileCut cut;
  TileId eye = spec.start;
  const auto look = [&](const Move& move) {
    const SelectionView view = selection_view(view_over(eye, move, contents), contents, occluder,
                                              RefinementPattern::restricted, focus);
    cut = select_tiles(tree, {&view, 1}, rules, cut).cut;
    result.tiles.push_back(counted(cut, spec.start.level - spec.levels + 1));
    for (const CutNode& node : cut) {
      if (!view.frustum.sees(node.volume)) continue;
      result.error_px =
          std::max(result.error_px, view.scale.error_px(node.volume, shortfall_of(tree, node).heights_m));
    }
  };
  look(walk.empty() ? Move{0, 1} : walk.front());
  for (const Move& move : walk) {
    eye = moved(eye, move);
    look(move);
  }
  return result;
}

}  // namespace cairn
