#include "runtime/paging/tile_loader.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <exception>
#include <string>
#include <utility>

namespace cairn {
namespace {

Error read_error(const IndexEntry& entry, const std::string& found) {
  return failed(std::string(to_string(entry.layer)) + " tile " + to_string(entry.id) +
                ": read: expected a tile, found " + found);
}

/// Calls `read`, whose exceptions become errors of the tile.
template <class Read>
Result<LoadedTile> read_guarded(const IndexEntry& entry, Read read) {
  try {
    return read();
  } catch (const std::exception& exception) {
    return read_error(entry, std::string("an exception: ") + exception.what());
  } catch (...) {
    return read_error(entry, "an exception of an unknown type");
  }
}

Result<LoadedTile> checked(const IndexEntry& entry, Result<LoadedTile> tile, int tile_size) {
  if (!tile) return tile;
  const Status status = check_tile(entry, *tile, tile_size);
  if (!status) return status.error();
  return tile;
}

}  // namespace

/// The finished loads.
class TileLoader::Results {
 public:
  void add(LoadResult result) {
    const std::lock_guard lock(mutex_);
    finished_.push_back(std::move(result));
  }

  std::vector<LoadResult> take(std::uint64_t limit_bytes) {
    std::vector<LoadResult> taken;
    std::uint64_t bytes = 0;
    const std::lock_guard lock(mutex_);
    while (!finished_.empty() && (taken.empty() || bytes < limit_bytes)) {
      taken.push_back(std::move(finished_.front()));
      finished_.pop_front();
      if (taken.back().tile) bytes += taken.back().tile->bytes();
    }
    return taken;
  }

 private:
  std::mutex mutex_;
  std::deque<LoadResult> finished_;  // guarded by mutex_
};

/// Hands one result of an asynchronous read on: the first, or an error if there is none.
class TileLoader::Delivery {
 public:
  Delivery(std::shared_ptr<Results> results, IndexEntry entry, std::stop_token stop, int tile_size)
      : results_(std::move(results)), entry_(entry), stop_(std::move(stop)), tile_size_(tile_size) {}
  Delivery(const Delivery&) = delete;
  Delivery& operator=(const Delivery&) = delete;
  ~Delivery() { finish(read_error(entry_, "a read that ended without a result")); }

  void finish(Result<LoadedTile> tile) {
    if (finished_.exchange(true)) return;
    results_->add({entry_, checked(entry_, std::move(tile), tile_size_), stop_.stop_requested()});
  }

 private:
  const std::shared_ptr<Results> results_;
  const IndexEntry entry_;
  const std::stop_token stop_;
  const int tile_size_;
  std::atomic<bool> finished_ = false;
};

TileLoader::TileLoader(TileSource source, int workers, int tile_size)
    : source_(std::move(source)), tile_size_(tile_size), results_(std::make_shared<Results>()) {
  assert(workers >= 1);
  const ReadTile* read = std::get_if<ReadTile>(&source_);
  for (int i = 0; read != nullptr && i < workers; ++i) {
    workers_.emplace_back([this, read](const std::stop_token& stop) { work(stop, *read); });
  }
}

TileLoader::~TileLoader() {
  for (std::jthread& worker : workers_) worker.request_stop();
  for (auto& [key, stop] : started_) stop.request_stop();
}

void TileLoader::submit(const IndexEntry& entry) {
  if (const RequestTile* request = std::get_if<RequestTile>(&source_)) return start(*request, entry);
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(entry);
  }
  wake_.notify_one();
}

void TileLoader::start(const RequestTile& request, const IndexEntry& entry) {
  std::stop_source stop;
  started_.insert_or_assign(key_of(entry), stop);
  const auto delivery = std::make_shared<Delivery>(results_, entry, stop.get_token(), tile_size_);
  const auto done = [delivery](Result<LoadedTile> tile) { delivery->finish(std::move(tile)); };
  const Result<LoadedTile> begun = read_guarded(entry, [&]() -> Result<LoadedTile> {
    request(entry, stop.get_token(), done);
    return LoadedTile{};
  });
  if (!begun) delivery->finish(begun.error());
}

std::vector<TileKey> TileLoader::withdraw(const std::function<bool(const TileKey&)>& stale) {
  std::vector<TileKey> withdrawn;
  for (auto& [key, stop] : started_) {
    if (stale(key)) stop.request_stop();
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(queue_, [&](const IndexEntry& entry) {
    if (!stale(key_of(entry))) return false;
    withdrawn.push_back(key_of(entry));
    return true;
  });
  return withdrawn;
}

std::vector<LoadResult> TileLoader::take(std::uint64_t limit_bytes) {
  std::vector<LoadResult> taken = results_->take(limit_bytes);
  for (const LoadResult& result : taken) started_.erase(key_of(result.entry));
  return taken;
}

void TileLoader::work(const std::stop_token& stop, const ReadTile& read) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !queue_.empty(); }) && !stop.stop_requested()) {
    const IndexEntry entry = queue_.front();
    queue_.pop_front();
    lock.unlock();
    results_->add({entry, checked(entry, read_guarded(entry, [&] { return read(entry); }), tile_size_)});
    lock.lock();
  }
}

}  // namespace cairn
