#include "builder/raster/raster_pool.h"

#include <algorithm>

namespace cairn {
namespace {

constexpr std::size_t kMostOpen = 16;

}  // namespace

Result<std::unique_ptr<RasterPool>> RasterPool::open(std::span<const std::filesystem::path> paths,
                                                     const OpenOptions& options) {
  std::unique_ptr<RasterPool> pool(new RasterPool);
  pool->most_open_ = std::clamp<std::size_t>(paths.size(), 1, kMostOpen);
  pool->options_ = options;
  pool->options_.cache_bytes = options.cache_bytes / pool->most_open_;
  for (const auto& path : paths) {
    auto raster = open_raster(path, pool->options_);
    if (!raster) return raster.error();
    pool->infos_.push_back((*raster)->info());
  }
  return pool;
}

Result<std::shared_ptr<const RasterSource>> RasterPool::acquire(std::size_t source) {
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const OpenSource& o) { return o.source == source; });
  if (found != open_.end()) {
    open_.splice(open_.begin(), open_, found);
    return open_.front().raster;
  }
  auto raster = open_raster(infos_[source].path, options_);
  if (!raster) return raster.error();
  if (open_.size() >= most_open_) open_.pop_back();
  open_.push_front({source, std::move(*raster)});
  return open_.front().raster;
}

void RasterPool::close() {
  const std::scoped_lock lock(mutex_);
  open_.clear();
}

}  // namespace cairn
