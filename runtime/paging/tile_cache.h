#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <unordered_map>
#include <vector>

#include "cairn/loaded_tile.h"

namespace cairn {

/// Decoded tiles in memory, the least recently used of which make room for others. Tiles are pinned anew in
/// each round; what the current round has pinned is never evicted. One thread only: the one that owns it.
class TileCache {
 public:
  /// Null where the tile is not here. The pointer holds until the tile is evicted.
  const LoadedTile* find(const TileKey& key) const;

  /// Adds a tile as the most recently used. REQUIRES: it is not here.
  void insert(const TileKey& key, LoadedTile tile);

  /// Begins a round: nothing is pinned.
  void unpin_all();
  /// Pins the tile for this round and counts it as used now; false where it is not here.
  bool pin(const TileKey& key);

  /// Evicts the least recently used tiles that are not pinned until no more than `limit` bytes are left or
  /// all are pinned; whether the limit was reached.
  bool shrink_to(std::uint64_t limit);

  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t pinned_bytes() const { return pinned_bytes_; }
  std::size_t size() const { return tiles_.size(); }

  /// The tiles evicted since the last call.
  std::vector<TileKey> take_evicted();

 private:
  struct Resident {
    TileKey key;
    LoadedTile tile;
    std::uint64_t bytes = 0;
    std::uint64_t pinned_in = 0;  // the round
  };
  using Residents = std::list<Resident>;

  Residents residents_;  // least recently used first
  std::unordered_map<TileKey, Residents::iterator> tiles_;
  std::vector<TileKey> evicted_;
  std::uint64_t round_ = 1;
  std::uint64_t bytes_ = 0;
  std::uint64_t pinned_bytes_ = 0;
};

}  // namespace cairn
