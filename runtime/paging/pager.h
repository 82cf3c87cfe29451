#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "runtime/paging/load_queue.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_cut.h"
#include "runtime/paging/tile_table.h"
#include "runtime/paging/tile_tree.h"
#include "runtime/view/view_frustum.h"

namespace cairn {

struct PagerOptions {
  std::uint64_t cache_bytes = 512u << 20;   ///< all that tiles may take, those being loaded included
  std::uint64_t delivery_bytes = 8u << 20;  ///< a frame hands over tiles until they reach this; one at least
  int workers = 2;
};

/// What is to be drawn, and what may be needed next, after all that is.
struct PagerTarget {
  TileCut cut;                      ///< its tiles have Pager::target_bytes() at most, or no coarser ones have
  std::vector<IndexEntry> objects;  ///< tiles of Layer::objects, the most needed first; each can be drawn
                                    ///< as soon as it is in memory, whatever the cut
  std::vector<IndexEntry> ahead;    ///< in any order
  std::uint64_t version = 0;        ///< grows with every change
};

/// What an update changed.
struct PagerChanges {
  bool drawn = false;            ///< drawn() is another cut
  bool availability = false;     ///< what the pack can show: the target has to be made anew
  std::vector<TileKey> evicted;  ///< no longer in memory
  std::vector<Error> errors;     ///< each tile once, until it can be read again
};

/// How far the pager is on the way to its target.
enum class PagerState : std::uint8_t {
  replacing,  ///< drawn() differs from the target
  loading,    ///< the target is drawn; something that may be needed next is missing or being read
  complete,   ///< the target is drawn, and nothing is missing
};

/// Brings the cut that is drawn towards the target, never through a hole: where the two differ, what is drawn
/// stays until all that replaces it is there.
///
/// Where more than 16 tiles would replace one, or memory is short, the tile's children come first, so that a
/// cold start shows coarse before fine. What is largest on the screen is loaded first: the smallest ratio of
/// distance to width, visible before invisible; then what lies ahead, if memory allows.
///
/// The byte budget is hard. Of it, each worker takes what reading one tile needs; a refinement begins only
/// if all its tiles fit beside all that is drawn, with a tile to spare, which a coarsening may use, so that
/// memory can always be won back. What an update no longer draws stays in memory until the next one, as the
/// caller may still hold it.
///
/// Threads: all of it belongs to one thread, the owner. Only the loader behind the queue has others.
class Pager {
 public:
  using Clock = TileTable::Clock;

  /// `table`, `contents` and the tree must outlive the pager. REQUIRES: cache_bytes >= least_bytes().
  Pager(TileTable& table, const TileAvailability& contents, const TileTree& tree, TileSource source,
        const PagerOptions& options);

  /// Returns the least budget that can work with this pack and this many workers.
  static std::uint64_t least_bytes(const TileAvailability& contents, int workers);
  /// Returns the bytes that the tiles of a target may have: the budget less what it takes to replace them.
  std::uint64_t target_bytes() const;

  /// Takes in what was loaded, replaces what can be replaced, and asks for what is missing. Never waits. Call
  /// it once per frame. `model_bytes` of the budget are taken by models of objects.
  PagerChanges update(const PagerTarget& target, std::span<const ViewFrustum> views, Clock::time_point now,
                      std::uint64_t model_bytes = 0);

  /// Covers the Earth; each tile's data is in memory. At first the root, which shows nothing.
  const TileCut& drawn() const { return drawn_; }
  PagerState state() const { return state_; }
  /// Whether the target is not drawn, and all that is missing cannot be read at present.
  bool only_failing() const { return state_ == PagerState::replacing && table_.only_failing(kReportedTries); }

  void add_to(PagingStats& stats) const;

 private:
  struct RankedChange;

  bool receive(Clock::time_point now);
  bool note_failure(const IndexEntry& entry, const Error& error, Clock::time_point now);
  bool replace_what_is_ready(const TileCut& target);
  bool replace_once(const TileCut& target);
  bool replace(const CutChange& change, const TileCut& target, TileCut& next);
  bool is_ready(const CutNode& tile) const;
  TileCut first_step(const CutChange& change, const TileCut& target) const;
  RankedChange rank(const CutChange& change, const TileCut& target, std::span<const ViewFrustum> views) const;
  void plan(const PagerTarget& target, std::span<const ViewFrustum> views);
  void admit(const CutChange& change, const TileCut& target);
  bool pin_or_request(std::span<const IndexEntry> sources, std::uint64_t limit);
  void submit_loads(Clock::time_point now);
  std::uint64_t bytes_of(const IndexEntry& entry) const;

  TileTable& table_;
  const TileAvailability& contents_;
  const TileTree& tree_;
  const PagerOptions options_;
  const std::uint64_t place_bytes_;  // of the tiles of one area at most
  const std::uint64_t all_bytes_;    // for what is in memory and what is under way, models included
  std::uint64_t capacity_;           // of these, without the models

  TileCut drawn_;
  std::vector<IndexEntry> last_drawn_;  // what the last update showed, if that was another cut
  std::uint64_t target_version_ = 0;    // of the last update
  PagerState state_ = PagerState::replacing;
  std::vector<CutChange> changes_;  // from what is drawn to the target

  // The plan of this update.
  std::unordered_set<TileKey> held_;  // drawn, or to be
  std::uint64_t held_bytes_ = 0;
  std::vector<IndexEntry> missing_;  // of those held, in the order in which they are needed

  std::vector<Error> errors_;
  std::uint64_t damaged_ = 0;
  LoadQueue queue_;  // last, so that its threads end before what they deliver to
};

}  // namespace cairn
