#include "runtime/paging/pager.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

namespace cairn {
namespace {

constexpr std::size_t kMostAtOnce = 16;    // tiles that may replace one without its children in between
constexpr std::uint64_t kSparePlaces = 5;  // a tile's four children, and a coarser tile to win memory back
constexpr std::uint64_t kLeastPlaces = 24;
// While it lasts, an ancestor is drawn instead of a tile that five reads in a row have failed to give.
constexpr std::chrono::milliseconds kShortestAbsence{320};

std::uint64_t bytes_of_a_place(const TileAvailability& contents) {
  const int size = contents.pack().header().tile_size;
  IndexEntry heights;
  heights.flags = kHasVoids;
  IndexEntry imagery;
  imagery.layer = Layer::imagery;
  return decoded_bytes_bound(heights, size) +
         (contents.has_imagery() ? decoded_bytes_bound(imagery, size) : 0);
}

// What the tree of tiles and its selections take beside the tiles themselves.
constexpr std::uint64_t kTreeBytes = 3u << 20;

/// Reading a tile takes its block, which may be as large as the tile, and the decoder's working memory,
/// beside the tile itself.
std::uint64_t bytes_of_workers(const TileAvailability& contents, int workers) {
  return 3 * bytes_of_a_place(contents) * static_cast<std::uint64_t>(workers);
}

/// Stands in for a tile that is damaged and has no ancestor.
LoadedTile flat_tile(const IndexEntry& entry, int size) {
  const std::int32_t height = entry.min_quanta + (entry.max_quanta - entry.min_quanta) / 2;
  const auto samples = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  return {
      std::make_shared<const HeightTile>(HeightTile{size, std::vector<std::int32_t>(samples, height), {}}),
      nullptr};
}

}  // namespace

/// How much a change of the cover is needed.
struct Pager::Need {
  CutChange change;
  bool visible = false;
  double distance_by_width = 0;

  bool before(const Need& other) const {
    return visible != other.visible ? visible : distance_by_width < other.distance_by_width;
  }
};

Pager::Pager(TileAvailability& contents, const TileTree& tree, TileSource source, const PagerOptions& options)
    : contents_(contents),
      tree_(tree),
      options_(options),
      place_bytes_(bytes_of_a_place(contents)),
      capacity_(options.cache_bytes - kTreeBytes - bytes_of_workers(contents, options.workers)),
      queue_(std::move(source), options.workers, contents.pack().header().tile_size) {
  assert(options.cache_bytes >= least_bytes(contents, options.workers));
  const CutNode& root = tree.node({kMinLevel, 0, 0}).best;
  drawn_ = {CutNode{root.area, std::nullopt, std::nullopt, root.volume}};
  target_ = {root};
}

std::uint64_t Pager::least_bytes(const TileAvailability& contents, int workers) {
  return kTreeBytes + bytes_of_workers(contents, workers) + kLeastPlaces * bytes_of_a_place(contents);
}

std::uint64_t Pager::target_bytes() const {
  return capacity_ - kSparePlaces * place_bytes_;
}

void Pager::set_target(TileCut target) {
  target_ = std::move(target);
  settled_ = false;
  outdated_ = false;
}

void Pager::set_ahead(std::vector<IndexEntry> ahead) {
  ahead_ = std::move(ahead);
  planned_ = false;
}

void Pager::advance() {
  receive(LoadQueue::Clock::now());
  if (settled_) return;
  while (replace_what_is_ready()) {
  }
}

void Pager::request(std::span<const ViewFrustum> views) {
  if (outdated_ || (settled_ && planned_)) return;
  const auto now = LoadQueue::Clock::now();
  plan(views);
  queue_.set_wanted(missing_, now);
  ask(now);
  planned_ = settled_ && queue_.size() == 0;
}

void Pager::receive(LoadQueue::Clock::time_point now) {
  if (contents_.restore(now)) outdated_ = true, ++availability_version_;
  for (LoadQueue::Delivery& delivery : queue_.deliver(options_.delivery_bytes, now)) {
    planned_ = false;
    if (delivery.tile) {
      unseen_.insert(key_of(delivery.entry));
      unseen_bytes_ += delivery.entry.bytes;
      cache_.insert(key_of(delivery.entry), std::move(*delivery.tile));
      if (pauses_.erase(key_of(delivery.entry)) > 0) reported_.erase(key_of(delivery.entry));
    } else {
      note_failure(delivery.entry, delivery.tile.error(), now);
    }
  }
}

void Pager::note_failure(const IndexEntry& entry, const Error& error, LoadQueue::Clock::time_point now) {
  const TileKey key = key_of(entry);
  const bool is_damaged = error.code != ErrorCode::failed;
  if (reported_.insert(key).second) {
    errors_.push_back(error);
    damaged_ += is_damaged;
  }
  const bool is_root = entry.id.level == kMinLevel || !contents_.nearest(entry.layer, parent_of(entry.id));
  if (is_root && !is_damaged) return;  // nothing can stand in for it: the queue goes on trying
  if (is_root && entry.layer == Layer::heights) {
    cache_.insert(key, flat_tile(entry, contents_.pack().header().tile_size));
    return;
  }
  if (is_damaged) {
    contents_.set_damaged(key);
  } else {
    contents_.set_failing(key, now + next_pause(key));
  }
  ++availability_version_;
  outdated_ = true;
}

/// Doubles the pause each time that a tile could not be read after one.
LoadQueue::Clock::duration Pager::next_pause(const TileKey& key) {
  const int doublings = std::min(pauses_[key]++, 4);
  return kShortestAbsence * (1 << doublings);
}

bool Pager::is_ready(const CutNode& tile) const {
  bool ready = true;
  tile.for_each_source([&](const IndexEntry& entry) { ready = ready && find(entry) != nullptr; });
  return ready;
}

/// The children of the area that a change refines, with no finer sources than the target has there.
TileCut Pager::first_step(const CutChange& change) const {
  TileCut children;
  std::size_t at = change.new_first;
  const std::size_t end = change.new_first + change.new_count;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId id = child_of(drawn_[change.old_first].area, quadrant);
    if (!is_valid(id)) continue;
    const CutNode& best = tree_.node(id).best;
    CutNode child{id, std::nullopt, std::nullopt, best.volume};
    const auto take = [&id](const auto& target, const auto& best_here, auto& source) {
      if (!target) return;
      source = target->id.level > id.level ? best_here : (source ? source : target);
    };
    for (; at < end && ancestor_of(target_[at].area, id.level) == id; ++at) {
      take(target_[at].heights, best.heights, child.heights);
      take(target_[at].imagery, best.imagery, child.imagery);
    }
    children.push_back(child);
  }
  return children;
}

/// One pass over all that differs; whether anything was replaced.
bool Pager::replace_what_is_ready() {
  const std::vector<CutChange> changes = changes_between(drawn_, target_);
  settled_ = changes.empty();
  TileCut next;
  next.reserve(target_.size());
  bool replaced = false;
  std::size_t kept = 0;
  const auto keep_until = [&](std::size_t end) {
    for (; kept < end; ++kept) next.push_back(std::move(drawn_[kept]));
  };
  for (const CutChange& change : changes) {
    keep_until(change.old_first);
    if (!replace(change, next)) continue;
    replaced = true;
    kept = change.old_first + change.old_count;
  }
  keep_until(drawn_.size());
  drawn_ = std::move(next);
  drawn_version_ += replaced;
  return replaced;
}

bool Pager::replace(const CutChange& change, TileCut& next) {
  const auto is_ready_tile = [this](const CutNode& tile) { return is_ready(tile); };
  const auto first = target_.begin() + static_cast<std::ptrdiff_t>(change.new_first);
  const auto last = first + static_cast<std::ptrdiff_t>(change.new_count);
  if (std::all_of(first, last, is_ready_tile)) {
    next.insert(next.end(), first, last);
    return true;
  }
  if (change.new_count <= 4) return false;
  const TileCut children = first_step(change);
  if (!std::all_of(children.begin(), children.end(), is_ready_tile)) return false;
  next.insert(next.end(), children.begin(), children.end());
  return true;
}

std::vector<IndexEntry> Pager::sources_for(const CutChange& change) const {
  std::vector<IndexEntry> sources;
  for (std::size_t i = 0; i < change.new_count; ++i) {
    target_[change.new_first + i].for_each_source([&](const IndexEntry& e) { sources.push_back(e); });
  }
  return sources;
}

Pager::Need Pager::need_for(const CutChange& change, std::span<const ViewFrustum> views) const {
  const CutNode& whole = change.coarsens() ? target_[change.new_first] : drawn_[change.old_first];
  const double width = 2 * glm::length(whole.volume.half_axes[1]);
  Need need{change, false, std::numeric_limits<double>::infinity()};
  for (const ViewFrustum& view : views) {
    need.visible = need.visible || view.sees(whole.volume);
    need.distance_by_width = std::min(need.distance_by_width, whole.volume.distance_m(view.eye()) / width);
  }
  return need;
}

/// Decides what is held in this round: all that is drawn, then what replaces it, as far as memory goes.
void Pager::plan(std::span<const ViewFrustum> views) {
  held_.clear();
  held_bytes_ = 0;
  missing_.clear();
  cache_.unpin_all();
  for (const CutNode& tile : drawn_) {
    tile.for_each_source([&](const IndexEntry& entry) { hold({&entry, 1}, capacity_); });
  }
  std::vector<Need> needs;
  for (const CutChange& change : changes_between(drawn_, target_)) needs.push_back(need_for(change, views));
  std::sort(needs.begin(), needs.end(), [](const Need& a, const Need& b) { return a.before(b); });
  for (const Need& need : needs) admit(need);
  for (const IndexEntry& entry : ahead_) hold({&entry, 1}, capacity_ - kSparePlaces * place_bytes_);
}

void Pager::admit(const Need& need) {
  const std::uint64_t limit = need.change.refines() ? capacity_ - place_bytes_ : capacity_;
  if (need.change.new_count <= kMostAtOnce && hold(sources_for(need.change), limit)) return;
  if (need.change.new_count <= 4) return;
  std::vector<IndexEntry> sources;
  for (const CutNode& child : first_step(need.change)) {
    child.for_each_source([&](const IndexEntry& entry) { sources.push_back(entry); });
  }
  hold(sources, limit);
}

/// Holds all of the tiles, or none if they do not fit.
bool Pager::hold(std::span<const IndexEntry> sources, std::uint64_t limit) {
  std::uint64_t bytes = held_bytes_;
  for (const IndexEntry& entry : sources) {
    if (!held_.contains(key_of(entry))) bytes += bytes_of(entry);
  }
  if (bytes > limit) return false;
  for (const IndexEntry& entry : sources) {
    if (!held_.insert(key_of(entry)).second) continue;
    held_bytes_ += bytes_of(entry);
    if (!cache_.pin(key_of(entry))) missing_.push_back(entry);
  }
  return true;
}

void Pager::ask(LoadQueue::Clock::time_point now) {
  for (const IndexEntry& entry : missing_) {
    if (queue_.is_full()) return;
    if (!queue_.is_waiting(key_of(entry), now)) continue;
    // What is under way and no longer wanted may still take room; the next update tries again.
    const std::uint64_t taken = queue_.bytes_under_way() + bytes_of(entry);
    if (taken > capacity_ || !cache_.shrink_to(capacity_ - taken)) return;
    queue_.submit(entry);
  }
}

std::uint64_t Pager::bytes_of(const IndexEntry& entry) const {
  const LoadedTile* tile = find(entry);
  return tile != nullptr ? tile->bytes() : decoded_bytes_bound(entry, contents_.pack().header().tile_size);
}

void Pager::note_seen(const IndexEntry& entry) {
  if (unseen_.erase(key_of(entry)) > 0) unseen_bytes_ -= entry.bytes;
}

std::vector<TileKey> Pager::take_evicted() {
  std::vector<TileKey> evicted = cache_.take_evicted();
  for (const TileKey& key : evicted) unseen_.erase(key);
  return evicted;
}

std::vector<Error> Pager::take_errors() {
  return std::exchange(errors_, {});
}

void Pager::add_to(PagingStats& stats) const {
  queue_.add_to(stats);
  stats.bytes_unseen = unseen_bytes_;
  stats.tiles_damaged = damaged_;
  stats.resident_bytes = cache_.bytes();
}

}  // namespace cairn
