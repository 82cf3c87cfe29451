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
  double hold = 1;      ///< a tile that is shown already counts this much more; >= 1
  std::uint64_t budget_bytes = std::numeric_limits<std::uint64_t>::max();  ///< of the tiles of the cut
};

/// What the tolerance needs of a pack.
struct TileSelection {
  TileCut cut;
  bool is_limited = false;  ///< the budget ended it: some areas are not good enough
};

/// The share of a tolerance that the tiles' own error may take; the rest is left to the mesh.
inline constexpr double kTileShare = 0.5;

/// Tiles that touch in a view, at an edge or a corner, show heights at most so many levels apart, and imagery
/// likewise, as far as the pack has finer tiles there.
inline constexpr int kLevelsApart = 2;

/// Returns the cut with the fewest of the pack's tiles that are good enough for all views, balanced, within
/// the budget.
///
/// Heights and imagery are selected each on their own. A tile is selected where the error of its parent's
/// heights, which the index holds, may project above heights_px in the tile's area (or the parent's texels
/// above texel_px). Its siblings need not be: their areas show windows of the parent, or of a coarser tile
/// where no view sees them. Outside a view nothing is selected but in the ring around the eye, where the
/// limits are sixteen times those of the view, so that a turn of the eye finds ground to show. Where there is
/// nothing to show but tiles below, these are always selected. With a tile those are selected that
/// kLevelsApart needs, across ±180°, too; tiles that touch at a pole only may be further apart.
///
/// The areas that are farthest from good enough come first. If the budget does not allow a tile, there are no
/// more, so that no area is farther from good enough than that one.
///
/// `held` is the cut before, whose tiles count more. It is a pure function of its arguments, and of its own
/// result as `held` it returns that result again.
TileSelection select_tiles(const TileTree& tree, std::span<const SelectionView> views,
                           const SelectionRules& rules, const TileCut& held);

/// The width of a sample or a texel of a level, in metres along the meridian.
double sample_width_m(int level, const PackHeader& pack);

/// What a cut lacks, against the finest data that the pack has there.
struct Shortfall {
  double heights_m = 0;  ///< how far finer heights may lie from those shown; 0 where there are none
  double texel_m = 0;    ///< the width of a texel where there are finer ones; 0 where there are none
};
Shortfall shortfall_of(const TileTree& tree, const CutNode& shown);

}  // namespace cairn
