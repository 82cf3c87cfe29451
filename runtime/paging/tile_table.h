#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cairn/loaded_tile.h"
#include "runtime/paging/tile_state.h"

namespace cairn {

/// The states of a pack's tiles, the data of those in memory, and the bytes that all of it takes. Each method
/// that changes a state says from which to which; any other state is a programming error.
///
/// Tiles are pinned anew in each round. Those that are not pinned make room for others, the least recently
/// used first. One thread only: the one that owns it.
class TileTable {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TileTable(int tile_size) : tile_size_(tile_size) {}

  TileState state(const TileKey& key) const;
  /// Null where the tile is not in memory. The pointer holds until the tile is evicted.
  const LoadedTile* find(const TileKey& key) const;

  /// What is needed now. Unknown tiles become wanted, stale ones under way; what is not among them becomes
  /// unknown, or stale if it is being read. Tiles in memory and absent ones stay as they are.
  void set_wanted(std::span<const IndexEntry> wanted, Clock::time_point now);
  /// Whether the tile can be submitted: wanted, or its pause is over.
  bool is_due(const TileKey& key, Clock::time_point now) const;
  /// wanted, pausing → under_way.
  void submit(const TileKey& key);
  /// stale → unknown: no worker had begun it.
  void withdraw(const TileKey& key);
  /// Ends a read. under_way, stale → resident.
  void arrive(const TileKey& key, LoadedTile tile);
  /// Ends a read that failed. under_way → pausing, until a time; stale → unknown. Returns how many reads in a
  /// row have failed.
  int fail(const TileKey& key, Clock::duration pause, Clock::time_point now);
  /// Ends a read without a result. under_way → wanted; stale → unknown.
  void stop(const TileKey& key);

  /// Any state but those in memory or being read → failing, for a time that doubles with each absence in a
  /// row, up to sixteen times `shortest`.
  void set_failing(const TileKey& key, Clock::duration shortest, Clock::time_point now);
  /// Any state but those in memory → damaged; ends a read.
  void set_damaged(const TileKey& key);
  /// failing → unknown, where its time has come; whether there were any.
  bool restore(Clock::time_point now);
  std::vector<TileKey> failing() const;
  /// Returns true once for each tile until it arrives.
  bool report(const TileKey& key);

  /// Puts a tile into memory that was not read. Any state but those in memory or being read → resident.
  void insert(const TileKey& key, LoadedTile tile);
  /// Begins a round. pinned → resident.
  void unpin_all();
  /// resident → pinned, as the most recently used; false where it is not in memory.
  bool pin(const TileKey& key);
  /// Evicts the least recently used tiles that are not pinned until no more than `limit` bytes are in memory
  /// or all are pinned; whether the limit was reached. resident → unknown.
  bool shrink_to(std::uint64_t limit);
  /// Returns the tiles evicted since the last call.
  std::vector<TileKey> take_evicted();
  /// Notes that a view sees the tile, if it is in memory.
  void note_seen(const TileKey& key);

  std::uint64_t bytes() const { return bytes_; }  ///< in memory
  std::uint64_t pinned_bytes() const { return pinned_bytes_; }
  /// Bytes that the tiles being read will need at most.
  std::uint64_t bytes_under_way() const { return bytes_under_way_; }
  std::size_t under_way() const { return under_way_; }
  std::size_t requested() const { return requested_.size(); }
  /// Whether tiles are requested or failing, and the last `tries` reads or more of each have failed.
  bool only_failing(int tries) const;
  /// How many reads in a row have failed. REQUIRES: a requested tile.
  int tries(const TileKey& key) const { return tiles_.at(key).tries; }
  /// When the tile was first wanted. REQUIRES: a requested tile.
  Clock::time_point wanted_since(const TileKey& key) const { return tiles_.at(key).since; }
  /// Of the blocks of all tiles that arrived, those of the ones that no view saw.
  std::uint64_t bytes_unseen() const { return bytes_unseen_; }

 private:
  struct Tile {
    TileKey key;
    IndexEntry entry;  // of a requested tile, and of one that was read
    TileState state = TileState::unknown;
    Clock::time_point since;  // of a requested tile
    Clock::time_point until;  // of a pause or an absence
    int tries = 0;            // reads in a row that failed
    int absences = 0;         // in a row
    bool is_reported = false;
    bool is_seen = false;
    std::uint64_t round = 0;  // in which it was last wanted
    std::uint64_t bytes = 0;  // in memory, or what it will need there at most
    LoadedTile data;
    std::list<Tile*>::iterator use;  // in uses_
  };
  using Tiles = std::unordered_map<TileKey, Tile>;

  Tile& tile_at(const TileKey& key);
  void leave_reading(Tile& tile);
  void forget(const TileKey& key);

  const int tile_size_;
  Tiles tiles_;
  std::unordered_set<TileKey> requested_;
  std::unordered_set<TileKey> absent_;
  std::list<Tile*> uses_;  // the tiles in memory, the least recently used first
  std::vector<TileKey> evicted_;
  std::uint64_t round_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t pinned_bytes_ = 0;
  std::uint64_t bytes_under_way_ = 0;
  std::size_t under_way_ = 0;
  std::uint64_t bytes_unseen_ = 0;
};

}  // namespace cairn
