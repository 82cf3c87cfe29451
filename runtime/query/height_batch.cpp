#include "cairn/height_batch.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

namespace cairn {
namespace {

using Heights = HeightBatches::Heights;

struct Batch {
  std::vector<LonLat> places;
  std::stop_token stop;
  std::promise<Result<Heights>> promise;
};

Error stopped_error() {
  return failed("batch of heights: expected to finish, found a request to stop");
}

/// Whether one of two tiles of a level comes first in the order in which a quadtree is walked, in which all
/// of a coarser tile's area is in a row.
bool is_before(const TileId& a, const TileId& b) {
  const auto dx = static_cast<std::uint32_t>(a.x ^ b.x), dy = static_cast<std::uint32_t>(a.y ^ b.y);
  return std::bit_width(dx) > std::bit_width(dy) ? a.x < b.x : a.y < b.y;
}

/// The places in the order of the tiles that hold them.
std::vector<std::size_t> order_by_tile(const std::vector<LonLat>& places, int level) {
  std::vector<std::pair<TileId, std::size_t>> tiles;
  tiles.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool is_place = std::isfinite(places[i].lon) && std::abs(places[i].lat) <= 90;
    tiles.emplace_back(is_place ? tile_at(places[i], level) : TileId{level, 0, 0}, i);
  }
  std::sort(tiles.begin(), tiles.end(), [](const auto& a, const auto& b) {
    return a.first == b.first ? a.second < b.second : is_before(a.first, b.first);
  });
  std::vector<std::size_t> order;
  order.reserve(places.size());
  for (const auto& [tile, place] : tiles) order.push_back(place);
  return order;
}

}  // namespace

struct HeightBatches::State {
  State(std::shared_ptr<const PackReader> p, int count) : pack(std::move(p)) {
    for (int i = 0; i < count; ++i) {
      workers.emplace_back([this](const std::stop_token& stop) { work(stop); });
    }
  }
  ~State() {
    for (std::jthread& worker : workers) worker.request_stop();
    workers.clear();
    for (Batch& batch : waiting) batch.promise.set_value(stopped_error());
  }

  void work(const std::stop_token& stop);
  Result<Heights> heights_of(const Batch& batch, const std::stop_token& stop, PackSampler& sampler) const;

  const std::shared_ptr<const PackReader> pack;
  std::mutex mutex;
  std::condition_variable_any wake;
  std::deque<Batch> waiting;  // guarded by mutex
  std::vector<std::jthread> workers;
};

void HeightBatches::State::work(const std::stop_token& stop) {
  PackSampler sampler(*pack);
  std::unique_lock lock(mutex);
  while (wake.wait(lock, stop, [this] { return !waiting.empty(); }) && !stop.stop_requested()) {
    Batch batch = std::move(waiting.front());
    waiting.pop_front();
    lock.unlock();
    batch.promise.set_value(heights_of(batch, stop, sampler));
    lock.lock();
  }
}

Result<Heights> HeightBatches::State::heights_of(const Batch& batch, const std::stop_token& stop,
                                                 PackSampler& sampler) const {
  const auto levels = pack->levels(Layer::heights);
  Heights heights(batch.places.size());
  if (!levels) return heights;
  for (const std::size_t place : order_by_tile(batch.places, levels->finest)) {
    if (stop.stop_requested() || batch.stop.stop_requested()) return stopped_error();
    Result<std::optional<PackSampler::Height>> height = sampler.height_at(batch.places[place]);
    if (!height) return height.error();
    heights[place] = *height;
  }
  return heights;
}

HeightBatches::HeightBatches(std::shared_ptr<const PackReader> pack, int workers) {
  assert(pack != nullptr && workers >= 1);
  state_ = std::make_unique<State>(std::move(pack), workers);
}
HeightBatches::HeightBatches(HeightBatches&&) noexcept = default;
HeightBatches& HeightBatches::operator=(HeightBatches&&) noexcept = default;
HeightBatches::~HeightBatches() = default;

std::future<Result<HeightBatches::Heights>> HeightBatches::sample(std::vector<LonLat> places,
                                                                  std::stop_token stop) {
  Batch batch{std::move(places), std::move(stop), {}};
  std::future<Result<Heights>> future = batch.promise.get_future();
  {
    const std::lock_guard lock(state_->mutex);
    state_->waiting.push_back(std::move(batch));
  }
  state_->wake.notify_one();
  return future;
}

}  // namespace cairn
