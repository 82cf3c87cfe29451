#include "runtime/paging/tile_table.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cairn {

TileState TileTable::state(const TileKey& key) const {
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? TileState::unknown : found->second.state;
}

const LoadedTile* TileTable::find(const TileKey& key) const {
  const auto found = tiles_.find(key);
  return found != tiles_.end() && is_in_memory(found->second.state) ? &found->second.data : nullptr;
}

TileTable::Tile& TileTable::tile_at(const TileKey& key) {
  Tile& tile = tiles_[key];
  tile.key = key;
  return tile;
}

/// A tile about which there is something to remember stays in the table, without a request.
void TileTable::forget(const TileKey& key) {
  requested_.erase(key);
  Tile& tile = tiles_.at(key);
  tile.state = TileState::unknown;
  tile.tries = 0;
  if (tile.absences == 0 && !tile.is_reported) tiles_.erase(key);
}

void TileTable::set_wanted(std::span<const IndexEntry> wanted, Clock::time_point now) {
  ++round_;
  for (const IndexEntry& entry : wanted) {
    const TileKey key = key_of(entry);
    Tile& tile = tile_at(key);
    tile.entry = entry;
    tile.round = round_;
    if (tile.state == TileState::stale) tile.state = TileState::under_way;
    if (tile.state != TileState::unknown) continue;
    tile.state = TileState::wanted;
    tile.since = now;
    requested_.insert(key);
  }
  for (const TileKey& key : std::vector<TileKey>(requested_.begin(), requested_.end())) {
    Tile& tile = tiles_.at(key);
    if (tile.round == round_) continue;
    if (is_being_read(tile.state)) {
      tile.state = TileState::stale;
    } else {
      forget(key);
    }
  }
}

bool TileTable::is_due(const TileKey& key, Clock::time_point now) const {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) return false;
  const Tile& tile = found->second;
  return tile.state == TileState::wanted || (tile.state == TileState::pausing && now >= tile.until);
}

void TileTable::submit(const TileKey& key) {
  Tile& tile = tiles_.at(key);
  assert(tile.state == TileState::wanted || tile.state == TileState::pausing);
  tile.state = TileState::under_way;
  tile.bytes = decoded_bytes_bound(tile.entry, tile_size_);
  bytes_under_way_ += tile.bytes;
  ++under_way_;
}

void TileTable::leave_reading(Tile& tile) {
  assert(is_being_read(tile.state));
  bytes_under_way_ -= tile.bytes;
  --under_way_;
}

void TileTable::withdraw(const TileKey& key) {
  assert(state(key) == TileState::stale);
  leave_reading(tiles_.at(key));
  forget(key);
}

void TileTable::stop(const TileKey& key) {
  Tile& tile = tiles_.at(key);
  leave_reading(tile);
  if (tile.state == TileState::stale) return forget(key);
  tile.state = TileState::wanted;
}

int TileTable::fail(const TileKey& key, Clock::duration pause, Clock::time_point now) {
  Tile& tile = tiles_.at(key);
  leave_reading(tile);
  const int tries = ++tile.tries;
  if (tile.state == TileState::stale) {
    forget(key);
    return tries;
  }
  tile.state = TileState::pausing;
  tile.until = now + pause;
  return tries;
}

void TileTable::arrive(const TileKey& key, LoadedTile data) {
  Tile& tile = tiles_.at(key);
  leave_reading(tile);
  bytes_unseen_ += tile.entry.bytes;
  if (tile.absences > 0) tile.is_reported = false;
  tile.absences = 0;
  insert(key, std::move(data));
  tile.is_seen = false;
}

void TileTable::insert(const TileKey& key, LoadedTile data) {
  Tile& tile = tile_at(key);
  assert(!is_in_memory(tile.state));
  requested_.erase(key);
  absent_.erase(key);
  tile.state = TileState::resident;
  tile.tries = 0;
  tile.is_seen = true;
  tile.bytes = data.bytes();
  tile.data = std::move(data);
  tile.use = uses_.insert(uses_.end(), &tile);
  bytes_ += tile.bytes;
}

void TileTable::set_failing(const TileKey& key, Clock::duration shortest, Clock::time_point now) {
  Tile& tile = tile_at(key);
  assert(!is_in_memory(tile.state) && !is_being_read(tile.state));
  requested_.erase(key);
  absent_.insert(key);
  tile.state = TileState::failing;
  tile.tries = 0;
  tile.until = now + shortest * (1 << std::min(tile.absences++, 4));
}

void TileTable::set_damaged(const TileKey& key) {
  Tile& tile = tile_at(key);
  assert(!is_in_memory(tile.state));
  if (is_being_read(tile.state)) leave_reading(tile);
  requested_.erase(key);
  absent_.insert(key);
  tile.state = TileState::damaged;
}

bool TileTable::restore(Clock::time_point now) {
  bool any = false;
  for (const TileKey& key : failing()) {
    if (tiles_.at(key).until > now) continue;
    absent_.erase(key);
    forget(key);
    any = true;
  }
  return any;
}

std::vector<TileKey> TileTable::failing() const {
  std::vector<TileKey> failing;
  for (const TileKey& key : absent_) {
    if (state(key) == TileState::failing) failing.push_back(key);
  }
  return failing;
}

bool TileTable::report(const TileKey& key) {
  return !std::exchange(tile_at(key).is_reported, true);
}

void TileTable::unpin_all() {
  // The pinned tiles were used last, but for those that arrived since.
  for (auto at = uses_.rbegin(); at != uses_.rend() && pinned_bytes_ > 0; ++at) {
    if ((*at)->state != TileState::pinned) continue;
    (*at)->state = TileState::resident;
    pinned_bytes_ -= (*at)->bytes;
  }
}

bool TileTable::pin(const TileKey& key) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end() || !is_in_memory(found->second.state)) return false;
  Tile& tile = found->second;
  if (tile.state == TileState::pinned) return true;
  tile.state = TileState::pinned;
  pinned_bytes_ += tile.bytes;
  uses_.splice(uses_.end(), uses_, tile.use);
  return true;
}

bool TileTable::shrink_to(std::uint64_t limit) {
  for (auto at = uses_.begin(); bytes_ > limit && at != uses_.end();) {
    Tile& tile = **at;
    if (tile.state == TileState::pinned) {
      ++at;
      continue;
    }
    at = uses_.erase(at);
    bytes_ -= tile.bytes;
    tile.data = {};
    evicted_.push_back(tile.key);
    forget(TileKey(tile.key));
  }
  return bytes_ <= limit;
}

std::vector<TileKey> TileTable::take_evicted() {
  return std::exchange(evicted_, {});
}

void TileTable::note_seen(const TileKey& key) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end() || !is_in_memory(found->second.state)) return;
  Tile& tile = found->second;
  if (!std::exchange(tile.is_seen, true)) bytes_unseen_ -= tile.entry.bytes;
}

bool TileTable::only_failing(int tries) const {
  const auto is_failing = [&](const TileKey& key) { return state(key) == TileState::failing; };
  const auto has_failed = [&](const TileKey& key) { return tiles_.at(key).tries >= tries; };
  const bool any = !requested_.empty() || std::any_of(absent_.begin(), absent_.end(), is_failing);
  return any && std::all_of(requested_.begin(), requested_.end(), has_failed);
}

}  // namespace cairn
