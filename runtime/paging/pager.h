#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "runtime/paging/load_queue.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_cache.h"
#include "runtime/paging/tile_cut.h"
#include "runtime/paging/tile_tree.h"
#include "runtime/view/view_frustum.h"

namespace cairn {

struct PagerOptions {
  std::uint64_t cache_bytes = 512u << 20;   ///< all that tiles may take, those being loaded included
  std::uint64_t delivery_bytes = 8u << 20;  ///< a frame hands over tiles until they reach this; one at least
  int workers = 2;
};

/// Brings the cover that is drawn towards the cover that is wanted, never through a hole: where the two
/// differ, what is drawn stays until all that replaces it is there.
///
/// Where more than 16 tiles would replace one, or memory is short, the tile's children come first, so that a
/// cold start shows coarse before fine. What is largest on the screen is loaded first: the smallest ratio of
/// distance to width, visible before invisible; then what lies ahead, if memory allows.
///
/// The byte budget is hard. Of it, each worker takes what reading one tile needs; a refinement begins only
/// if all its tiles fit beside all that is drawn, with a tile to spare, which a coarsening may use, so that
/// memory can always be won back.
///
/// Threads: all of it belongs to one thread, the owner. Only the loader behind the queue has others.
class Pager {
 public:
  /// `contents` and its tree must outlive the pager; damaged tiles are noted in `contents`. REQUIRES:
  /// cache_bytes >= least_bytes().
  Pager(TileAvailability& contents, const TileTree& tree, TileSource source, const PagerOptions& options);

  /// The least budget that can work with this pack and this many workers.
  static std::uint64_t least_bytes(const TileAvailability& contents, int workers);

  /// The bytes that the tiles of a target may have: the budget less what it takes to replace them.
  std::uint64_t target_bytes() const;

  /// What to draw from now on. REQUIRES: its tiles have target_bytes() at most, or no
  /// coarser one has.
  void set_target(TileCut target);
  const TileCut& target() const { return target_; }
  /// What may be wanted next, after all that is.
  void set_ahead(std::vector<IndexEntry> ahead);

  /// Takes in what was loaded and replaces what can be replaced. Never waits.
  void advance();
  /// Asks for what is missing, and evicts to make room for it: let go of tiles that are drawn no more before.
  void request(std::span<const ViewFrustum> views);

  /// Covers the Earth; each tile's data is resident. At first the root, which shows nothing.
  const TileCut& drawn() const { return drawn_; }
  /// Counts the changes of drawn().
  std::uint64_t drawn_version() const { return drawn_version_; }
  bool is_settled() const { return settled_; }
  /// Whether all that is missing cannot be read at present.
  bool only_failing() const { return !settled_ && queue_.only_failing(); }
  /// Counts the changes of what the pack can show: after one, the target has to be made anew.
  std::uint64_t availability_version() const { return availability_version_; }

  const LoadedTile* find(const IndexEntry& entry) const { return cache_.find(key_of(entry)); }
  std::vector<TileKey> take_evicted();
  /// What went wrong since the last call; each tile once.
  std::vector<Error> take_errors();
  void add_to(PagingStats& stats) const;

  /// Notes that a view sees the tile.
  void note_seen(const IndexEntry& entry);

 private:
  struct Need;

  void receive(LoadQueue::Clock::time_point now);
  void note_failure(const IndexEntry& entry, const Error& error, LoadQueue::Clock::time_point now);
  LoadQueue::Clock::duration next_pause(const TileKey& key);
  bool replace_what_is_ready();
  bool replace(const CutChange& change, TileCut& next);
  bool is_ready(const CutNode& tile) const;
  TileCut first_step(const CutChange& change) const;
  Need need_for(const CutChange& change, std::span<const ViewFrustum> views) const;
  std::vector<IndexEntry> sources_for(const CutChange& change) const;
  void plan(std::span<const ViewFrustum> views);
  void admit(const Need& need);
  bool hold(std::span<const IndexEntry> sources, std::uint64_t limit);
  void ask(LoadQueue::Clock::time_point now);
  std::uint64_t bytes_of(const IndexEntry& entry) const;

  TileAvailability& contents_;
  const TileTree& tree_;
  const PagerOptions options_;
  const std::uint64_t place_bytes_;  // of the tiles of one area at most
  const std::uint64_t capacity_;     // of the cache and of what is under way

  TileCache cache_;
  TileCut drawn_;
  TileCut target_;
  std::vector<IndexEntry> ahead_;
  bool settled_ = false;
  bool planned_ = false;   // and nothing has changed since
  bool outdated_ = false;  // the target shows tiles that cannot be had any more
  std::uint64_t drawn_version_ = 1;
  std::uint64_t availability_version_ = 0;

  // The plan of this update.
  std::unordered_set<TileKey> held_;  // drawn, or to be
  std::uint64_t held_bytes_ = 0;
  std::vector<IndexEntry> missing_;  // of those held, in the order in which they are wanted

  std::unordered_set<TileKey> unseen_;  // in memory, and seen by no view since they were loaded
  std::uint64_t unseen_bytes_ = 0;      // of the blocks of all tiles that were loaded and not seen

  std::unordered_set<TileKey> reported_;
  std::vector<Error> errors_;
  std::unordered_map<TileKey, int> pauses_;  // of tiles whose reads fail
  std::uint64_t damaged_ = 0;
  LoadQueue queue_;  // last, so that its threads end before what they deliver to
};

}  // namespace cairn
