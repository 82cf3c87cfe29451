#pragma once

// START HERE: open a pack as a Terrain, call update() once a frame, draw the RenderList.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "cairn/pack_reader.h"
#include "cairn/paging_stats.h"
#include "cairn/read_tile.h"
#include "cairn/refinement_pattern.h"
#include "cairn/render_list.h"
#include "cairn/status.h"
#include "cairn/view_state.h"

namespace cairn {

struct TerrainOptions {
  std::uint64_t cache_bytes = 512u << 20;   ///< a hard limit on what tiles take in memory, loading included
  std::uint64_t delivery_bytes = 8u << 20;  ///< of new tiles per frame, but at least one tile
  int workers = 2;                          ///< threads that read and decode; 1…64
  double tolerance_px = 1;  ///< the screen error that a program allows: tiles take half of it at most, and
                            ///< leave the rest to its mesh; infinite for none
  double texel_px = 1;      ///< the width that texels may have on the screen where the pack has finer ones
  double object_px = 2;     ///< objects that are not larger on the screen are not loaded; infinite for none
  RefinementPattern pattern =
      RefinementPattern::restricted;  ///< not nine or window, which leave most of the Earth bare
  double tile_margin = 0.125;         ///< hysteresis in tiles, below 1; 0 for none
  double level_margin = 0.25;
  double look_ahead_s = 2;  ///< seconds along the flight for which tiles are loaded in advance; 0 for none
};

/// The terrain of one pack, for a program that flies over it: which tiles to draw, loaded in the background.
///
/// update() never waits for a disk. However slow or broken the disk is, its result covers the Earth without
/// overlaps, with data that is in memory. After the first tile has arrived, no place that the pack covers is
/// without data again.
///
/// If the cameras rest, the result becomes the coarsest tiles that are good enough for the views, whatever
/// happened before, hysteresis and tiles that cannot be read aside. Nothing in a viewport is then farther
/// from the pack's finest heights than half of tolerance_px, and no texel is wider than texel_px where the
/// pack has finer ones. Tiles that touch in a view show heights at most two levels apart, as far as the pack
/// has finer ones. Around a camera, in the ring that `pattern` names, tiles outside the view are held ready
/// at sixteen times these limits. Objects are loaded where one may be larger in a view than object_px; they
/// take a quarter of the budget at most, and their models count too. Where the byte budget does not allow
/// that, the worst place is made as good as it can be; RenderList says how good.
///
/// Threads: a Terrain belongs to one thread, usually the one that renders. docs/runtime-threads.md has the
/// rules.
class Terrain {
 public:
  /// Opens a terrain. The error is usage if an option is out of range, or if the budget is too small, with
  /// the least budget that works.
  static Result<Terrain> open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options = {});

  /// Opens a terrain whose tiles come from elsewhere: `read` is called from the worker threads, `request`
  /// from the thread that calls update(), with up to eight reads per worker under way at once.
  static Result<Terrain> open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                              ReadTile read);
  static Result<Terrain> open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                              RequestTile request);

  Terrain(Terrain&&) noexcept;
  Terrain& operator=(Terrain&&) noexcept;
  /// Waits for the worker threads' reads in progress, one per worker at most. Asynchronous reads are asked to
  /// stop, and none is waited for.
  ~Terrain();

  /// Returns what to draw. Call it once per frame; `dt_s` is the time since the last call, in seconds. The
  /// list holds until the next call. A view or a time that is out of range is an error in the list, and what
  /// was drawn stays.
  const RenderList& update(const ViewState& view, double dt_s);

  /// Updates for several views of the terrain at once, 1 to 64. The list is good enough for all of them.
  /// A view keeps its place in the span from call to call.
  const RenderList& update(std::span<const ViewState> views, double dt_s);

  /// Changes TerrainOptions::tolerance_px from the next update on. REQUIRES: above 0.
  void set_tolerance_px(double tolerance_px);

  /// Returns the height, in the pack's vertical datum, of the ground as it is drawn now; nullopt where
  /// nothing is drawn or where it is void.
  std::optional<double> ground_height_m(LonLat place) const;

  /// Returns the camera's tile for which the last update made the map.
  TileId eye_tile() const;
  PagingStats stats() const;

 private:
  struct State;
  static Result<Terrain> open_source(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                                     TileSource source);
  explicit Terrain(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
