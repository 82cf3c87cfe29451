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

/// A change of the drawn cut, and how much it is needed.
struct Pager::RankedChange {
  CutChange change;
  bool visible = false;
  double distance_by_width = 0;

  bool before(const RankedChange& other) const {
    return visible != other.visible ? visible : distance_by_width < other.distance_by_width;
  }
};

Pager::Pager(TileTable& table, const TileAvailability& contents, const TileTree& tree, TileSource source,
             const PagerOptions& options)
    : table_(table),
      contents_(contents),
      tree_(tree),
      options_(options),
      place_bytes_(bytes_of_a_place(contents)),
      all_bytes_(options.cache_bytes - kTreeBytes - bytes_of_workers(contents, options.workers)),
      capacity_(all_bytes_),
      queue_(table, std::move(source), options.workers, contents.pack().header().tile_size) {
  assert(options.cache_bytes >= least_bytes(contents, options.workers));
  const CutNode& root = tree.node({kMinLevel, 0, 0}).best;
  drawn_ = {CutNode{root.area, std::nullopt, std::nullopt, root.volume}};
}

std::uint64_t Pager::least_bytes(const TileAvailability& contents, int workers) {
  return kTreeBytes + bytes_of_workers(contents, workers) + kLeastPlaces * bytes_of_a_place(contents);
}

std::uint64_t Pager::target_bytes() const {
  return capacity_ - kSparePlaces * place_bytes_;
}

PagerChanges Pager::update(const PagerTarget& target, std::span<const ViewFrustum> views,
                           Clock::time_point now, std::uint64_t model_bytes) {
  PagerChanges changes;
  // However much memory the models take, kLeastPlaces places stay for the ground.
  const std::uint64_t capacity = all_bytes_ - std::min(model_bytes, all_bytes_ - kLeastPlaces * place_bytes_);
  if (capacity != std::exchange(capacity_, capacity) && state_ == PagerState::complete)
    state_ = PagerState::loading;
  if (target.version != target_version_) state_ = PagerState::replacing;
  target_version_ = target.version;
  changes.availability = receive(now);
  const bool has_let_go = !std::exchange(last_drawn_, {}).empty();
  if (state_ == PagerState::complete && has_let_go) state_ = PagerState::loading;
  if (state_ == PagerState::replacing) {
    changes.drawn = replace_what_is_ready(target.cut);
    if (changes_.empty()) state_ = PagerState::loading;
  }
  if (!changes.availability && state_ != PagerState::complete) {
    plan(target, views);
    queue_.set_wanted(missing_, now);
    submit_loads(now);
    if (state_ == PagerState::loading && table_.requested() == 0) state_ = PagerState::complete;
  }
  changes.evicted = table_.take_evicted();
  changes.errors = std::exchange(errors_, {});
  return changes;
}

/// Takes in what was loaded. Returns whether what the pack can show has changed.
bool Pager::receive(Clock::time_point now) {
  bool changed = table_.restore(now);
  for (const LoadQueue::Failure& failure : queue_.receive(options_.delivery_bytes, now)) {
    if (note_failure(failure.entry, failure.error, now)) changed = true;
  }
  return changed;
}

bool Pager::note_failure(const IndexEntry& entry, const Error& error, Clock::time_point now) {
  const TileKey key = key_of(entry);
  const bool is_damaged = error.code != ErrorCode::failed;
  if (table_.report(key)) {
    errors_.push_back(error);
    damaged_ += is_damaged;
  }
  if (entry.layer == Layer::objects) {  // nothing stands for them
    if (!is_damaged) table_.set_failing(key, kShortestAbsence, now);
    return true;
  }
  const bool is_root = entry.id.level == kMinLevel || !contents_.nearest(entry.layer, parent_of(entry.id));
  if (is_root && !is_damaged) return false;  // nothing can stand in for it: the queue goes on trying
  if (is_root && entry.layer == Layer::heights) {
    table_.insert(key, flat_tile(entry, contents_.pack().header().tile_size));
    return false;
  }
  if (!is_damaged) table_.set_failing(key, kShortestAbsence, now);
  return true;
}

bool Pager::is_ready(const CutNode& tile) const {
  bool ready = true;
  tile.for_each_source([&](const IndexEntry& e) { ready = ready && table_.find(key_of(e)) != nullptr; });
  return ready;
}

/// The children of the area that a change refines, with no finer sources than the target has there.
TileCut Pager::first_step(const CutChange& change, const TileCut& target) const {
  TileCut children;
  std::size_t at = change.new_first;
  const std::size_t end = change.new_first + change.new_count;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId id = child_of(drawn_[change.old_first].area, quadrant);
    if (!is_valid(id)) continue;
    const CutNode& best = tree_.node(id).best;
    CutNode child{id, std::nullopt, std::nullopt, best.volume};
    const auto take = [&id](const auto& wanted, const auto& best_here, auto& source) {
      if (!wanted) return;
      source = wanted->id.level > id.level ? best_here : (source ? source : wanted);
    };
    for (; at < end && ancestor_of(target[at].area, id.level) == id; ++at) {
      take(target[at].heights, best.heights, child.heights);
      take(target[at].imagery, best.imagery, child.imagery);
    }
    children.push_back(child);
  }
  return children;
}

/// Replaces what can be replaced, and notes where drawn() still differs from the target. Returns whether
/// anything was replaced.
bool Pager::replace_what_is_ready(const TileCut& target) {
  std::vector<IndexEntry> before;
  for (const CutNode& node : drawn_) {
    node.for_each_source([&](const IndexEntry& entry) { before.push_back(entry); });
  }
  bool replaced = false;
  for (bool again = true; again; replaced = replaced || again) {
    changes_ = changes_between(drawn_, target);
    again = replace_once(target);
  }
  if (replaced) last_drawn_ = std::move(before);
  return replaced;
}

/// One pass over all that differs; whether anything was replaced.
bool Pager::replace_once(const TileCut& target) {
  TileCut next;
  next.reserve(target.size());
  bool replaced = false;
  std::size_t kept = 0;
  const auto keep_until = [&](std::size_t end) {
    for (; kept < end; ++kept) next.push_back(std::move(drawn_[kept]));
  };
  for (const CutChange& change : changes_) {
    keep_until(change.old_first);
    if (!replace(change, target, next)) continue;
    replaced = true;
    kept = change.old_first + change.old_count;
  }
  keep_until(drawn_.size());
  drawn_ = std::move(next);
  return replaced;
}

bool Pager::replace(const CutChange& change, const TileCut& target, TileCut& next) {
  const auto is_ready_tile = [this](const CutNode& tile) { return is_ready(tile); };
  const auto first = target.begin() + static_cast<std::ptrdiff_t>(change.new_first);
  const auto last = first + static_cast<std::ptrdiff_t>(change.new_count);
  if (std::all_of(first, last, is_ready_tile)) {
    next.insert(next.end(), first, last);
    return true;
  }
  if (change.new_count <= 4) return false;
  const TileCut children = first_step(change, target);
  if (!std::all_of(children.begin(), children.end(), is_ready_tile)) return false;
  next.insert(next.end(), children.begin(), children.end());
  return true;
}

Pager::RankedChange Pager::rank(const CutChange& change, const TileCut& target,
                                std::span<const ViewFrustum> views) const {
  const CutNode& whole = change.coarsens() ? target[change.new_first] : drawn_[change.old_first];
  const double width = 2 * glm::length(whole.volume.half_axes[1]);
  RankedChange ranked{change, false, std::numeric_limits<double>::infinity()};
  for (const ViewFrustum& view : views) {
    ranked.visible = ranked.visible || view.sees(whole.volume);
    ranked.distance_by_width =
        std::min(ranked.distance_by_width, whole.volume.distance_m(view.eye()) / width);
  }
  return ranked;
}

/// Decides what is held in this round: all that is drawn, then what replaces it, as far as memory goes.
void Pager::plan(const PagerTarget& target, std::span<const ViewFrustum> views) {
  held_.clear();
  held_bytes_ = 0;
  missing_.clear();
  table_.unpin_all();
  // What is drawn stays, though models have come into memory since it was chosen.
  const auto hold = [this](const IndexEntry& entry) { pin_or_request({&entry, 1}, all_bytes_); };
  for (const CutNode& tile : drawn_) tile.for_each_source(hold);
  for (const IndexEntry& entry : last_drawn_) hold(entry);
  // Objects in memory stay; those that are not there come after the ground that they stand on.
  for (const IndexEntry& entry : target.objects) {
    if (is_in_memory(table_.state(key_of(entry)))) hold(entry);
  }
  std::vector<RankedChange> ranked;
  for (const CutChange& change : changes_) ranked.push_back(rank(change, target.cut, views));
  std::sort(ranked.begin(), ranked.end(),
            [](const RankedChange& a, const RankedChange& b) { return a.before(b); });
  for (const RankedChange& each : ranked) admit(each.change, target.cut);
  const std::uint64_t spared = capacity_ - kSparePlaces * place_bytes_;
  for (const IndexEntry& entry : target.objects) pin_or_request({&entry, 1}, spared);
  for (const IndexEntry& entry : target.ahead) pin_or_request({&entry, 1}, spared);
}

void Pager::admit(const CutChange& change, const TileCut& target) {
  const std::uint64_t limit = change.refines() ? capacity_ - place_bytes_ : capacity_;
  std::vector<IndexEntry> sources;
  const auto add = [&](const IndexEntry& entry) { sources.push_back(entry); };
  for (std::size_t i = 0; i < change.new_count; ++i) target[change.new_first + i].for_each_source(add);
  if (change.new_count <= kMostAtOnce && pin_or_request(sources, limit)) return;
  if (change.new_count <= 4) return;
  sources.clear();
  for (const CutNode& child : first_step(change, target)) child.for_each_source(add);
  pin_or_request(sources, limit);
}

/// Holds all of the tiles, or none if they do not fit.
bool Pager::pin_or_request(std::span<const IndexEntry> sources, std::uint64_t limit) {
  std::uint64_t bytes = held_bytes_;
  for (const IndexEntry& entry : sources) {
    if (!held_.contains(key_of(entry))) bytes += bytes_of(entry);
  }
  if (bytes > limit) return false;
  for (const IndexEntry& entry : sources) {
    if (!held_.insert(key_of(entry)).second) continue;
    held_bytes_ += bytes_of(entry);
    if (!table_.pin(key_of(entry))) missing_.push_back(entry);
  }
  return true;
}

void Pager::submit_loads(Clock::time_point now) {
  for (const IndexEntry& entry : missing_) {
    if (queue_.is_full()) return;
    if (!table_.is_due(key_of(entry), now)) continue;
    // What is under way and no longer needed may still take room; the next update tries again.
    const std::uint64_t taken = table_.bytes_under_way() + bytes_of(entry);
    if (taken > capacity_ || !table_.shrink_to(capacity_ - taken)) return;
    queue_.submit(entry);
  }
}

std::uint64_t Pager::bytes_of(const IndexEntry& entry) const {
  const LoadedTile* tile = table_.find(key_of(entry));
  return tile != nullptr ? tile->bytes() : decoded_bytes_bound(entry, contents_.pack().header().tile_size);
}

void Pager::add_to(PagingStats& stats) const {
  queue_.add_to(stats);
  stats.tiles_damaged = damaged_;
  stats.resident_bytes = table_.bytes();
  stats.bytes_unseen = table_.bytes_unseen();
}

}  // namespace cairn
