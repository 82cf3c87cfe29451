#include "runtime/paging/tile_cache.h"

#include <cassert>
#include <utility>

namespace cairn {

const LoadedTile* TileCache::find(const TileKey& key) const {
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? nullptr : &found->second->tile;
}

void TileCache::insert(const TileKey& key, LoadedTile tile) {
  assert(!tiles_.contains(key));
  const std::uint64_t bytes = tile.bytes();
  tiles_[key] = residents_.insert(residents_.end(), {key, std::move(tile), bytes, 0});
  bytes_ += bytes;
}

void TileCache::unpin_all() {
  ++round_;
  pinned_bytes_ = 0;
}

bool TileCache::pin(const TileKey& key) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) return false;
  Resident& resident = *found->second;
  if (resident.pinned_in == round_) return true;
  resident.pinned_in = round_;
  pinned_bytes_ += resident.bytes;
  residents_.splice(residents_.end(), residents_, found->second);
  return true;
}

bool TileCache::shrink_to(std::uint64_t limit) {
  for (auto at = residents_.begin(); bytes_ > limit && at != residents_.end();) {
    // Pinning moves a tile to the end, so that behind the first pinned one there are only pinned ones and
    // those that were inserted in this round.
    if (at->pinned_in == round_) {
      ++at;
      continue;
    }
    bytes_ -= at->bytes;
    evicted_.push_back(at->key);
    tiles_.erase(at->key);
    at = residents_.erase(at);
  }
  return bytes_ <= limit;
}

std::vector<TileKey> TileCache::take_evicted() {
  return std::exchange(evicted_, {});
}

}  // namespace cairn
