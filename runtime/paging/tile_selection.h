#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cairn/view_state.h"
#include "runtime/paging/tile_cut.h"
#include "runtime/paging/tile_tree.h"
#include "runtime/scene/focus_tile.h"
#include "runtime/scene/scene_map.h"
#include "runtime/scene/split_set.h"
#include "runtime/view/screen_scale.h"
#include "runtime/view/view_frustum.h"

namespace cairn {

/// One of the views that tiles are selected for.
struct SelectionView {
  ViewFrustum frustum;
  ScreenScale scale;
  TileId eye_tile;
  SplitSet ring;  ///< what the scene map around the eye splits: there, tiles outside the view count, too
};

/// Builds what a view selects tiles by. `focus` holds the eye's tile over the views of a flight. REQUIRES: a
/// pattern of several levels.
SelectionView selection_view(const ViewState& view, const TileAvailability& contents,
                             const Occluder& occluder, RefinementPattern pattern, FocusTile& focus);

/// When an area is good enough.
struct SelectionRules {
  double heights_px = 0.5;  ///< the screen error that its heights may have; > 0
  double texel_px = 1;  ///< the width that its texels may have on the screen; infinite: imagery is left out
  double hold = 1;      ///< an area that is split already counts this much more; >= 1
  std::uint64_t budget_bytes = std::numeric_limits<std::uint64_t>::max();  ///< of the tiles of the cut
};

/// What the tolerance needs of a pack.
struct TileSelection {
  TileCut cut;
  bool is_limited = false;  ///< the budget ended it: some areas are not good enough
};

/// The share of a tolerance that the tiles' own error may take; the rest is left to the mesh.
inline constexpr double kTileShare = 0.5;

/// Returns the coarsest cut of the pack's tiles that is good enough for all views, within the budget.
///
/// An area in a view is split where the error of its heights, which the index holds, may project above
/// heights_px and the pack has finer ones, and where its texels may project above texel_px and the pack has
/// finer ones. Children show finer heights only where the heights needed it, and finer imagery likewise.
/// Around the eye, inside the ring, areas outside the view are split likewise, with four times the limits, so
/// that a turn of the eye finds ground to show. Areas that have nothing to show but tiles below them are
/// always split.
///
/// The areas that are farthest from good enough are split first. If the budget does not allow a split, there
/// are no more, so that no area is farther from good enough than that one.
///
/// `held` is the cut before, whose splits count more. It is a pure function of its arguments.
TileSelection select_tiles(const TileTree& tree, std::span<const SelectionView> views,
                           const SelectionRules& rules, const TileCut& held);

/// The width of a sample or a texel of a level, in metres along the meridian.
double sample_width_m(int level, int tile_size);

/// What a cut lacks, against the finest data that the pack has there.
struct Shortfall {
  double heights_m = 0;  ///< how far finer heights may lie from those shown; 0 where there are none
  double texel_m = 0;    ///< the width of a texel where there are finer ones; 0 where there are none
};
Shortfall shortfall_of(const TileTree& tree, const CutNode& shown);

}  // namespace cairn
