#include "builder/raster/raster_pool.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "builder/raster/whole_metre_probe.h"

namespace cairn {
namespace {

constexpr std::size_t kMostOpen = 16;
constexpr std::size_t kMostWholeBytes = std::size_t{8} << 20;
constexpr std::size_t kLeastWhole = 16;  // sources read whole that there is room for, or none is

std::size_t bytes_as_floats(const RasterInfo& info) {
  return static_cast<std::size_t>(info.columns) * static_cast<std::size_t>(info.rows) * sizeof(float);
}

// Raises posts lower than what the user says that a sea is; a void stays one.
void clamp_sea(const RasterInfo& info, std::span<float> heights) {
  if (!info.overrides.sea_clamp_m) return;
  const auto sea = static_cast<float>(*info.overrides.sea_clamp_m);
  for (float& height : heights) height = height < sea ? sea : height;
}

}  // namespace

Result<std::unique_ptr<RasterPool>> RasterPool::open(std::span<const std::filesystem::path> paths,
                                                     const OpenOptions& options, Content content) {
  std::unique_ptr<RasterPool> pool(new RasterPool);
  pool->options_ = options;
  if (auto status = pool->ask_all(paths, content); !status) return status.error();
  pool->has_voids_ = std::vector<std::atomic<char>>(paths.size());
  pool->content_ = content;
  pool->set_cache_bytes(options.cache_bytes);
  return pool;
}

std::unique_ptr<RasterPool> RasterPool::describe(std::vector<RasterInfo> infos, std::vector<bool> available,
                                                 const OpenOptions& options, Content content) {
  std::unique_ptr<RasterPool> pool(new RasterPool);
  pool->options_ = options;
  pool->has_voids_ = std::vector<std::atomic<char>>(infos.size());
  pool->infos_ = std::move(infos);
  pool->available_ = std::move(available);
  pool->content_ = content;
  pool->set_cache_bytes(options.cache_bytes);
  return pool;
}

Result<std::unique_ptr<RasterSource>> RasterPool::open_source(std::size_t source,
                                                              const OpenOptions& options) const {
  const std::filesystem::path& path = infos_[source].path;
  if (available_.empty() || available_[source]) return open_raster(path, options);
  return failed(path.string() + ": expected no post of it to be needed here, found that some are");
}

void RasterPool::note_voids(std::size_t source, std::span<const float> heights) {
  if (has_voids(source)) return;
  int voids = 0;  // no early end, so that the loop is one of vectors
  for (const float h : heights) voids |= h != h ? 1 : 0;
  if (voids != 0) has_voids_[source] = 1;
}

// Hardly anything is decoded, so the sources need no cache yet.
Status RasterPool::ask_all(std::span<const std::filesystem::path> paths, Content content) {
  infos_.resize(paths.size());
  std::vector<std::optional<Error>> errors(paths.size());
  OpenOptions asking = options_;
  asking.cache_bytes = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, paths.size()), [&](const auto& range) {
    for (std::size_t s = range.begin(); s < range.end(); ++s) {
      const auto raster = open_raster(paths[s], asking);
      if (raster) {
        infos_[s] = (*raster)->info();
        if (content == Content::heights && !infos_[s].whole_metres)
          infos_[s].whole_metres = seems_whole_metres(**raster);
      } else {
        errors[s] = raster.error();
      }
    }
  });
  const auto first = std::find_if(errors.begin(), errors.end(), [](const auto& e) { return e.has_value(); });
  return first == errors.end() ? Status() : Status(**first);
}

// By what there is to keep: the posts of sources that are read whole, and the caches of the others.
void RasterPool::set_cache_bytes(std::size_t cache_bytes) {
  close();
  if (content_ == Content::heights) most_whole_bytes_ = std::min(kMostWholeBytes, cache_bytes / kLeastWhole);
  double small = 0, large = 0;
  std::size_t large_count = 0;
  for (const RasterInfo& info : infos_) {
    (is_small(info) ? small : large) += static_cast<double>(bytes_as_floats(info));
    if (!is_small(info)) ++large_count;
  }
  const double share = large == 0 ? 1 : small == 0 ? 0 : std::clamp(small / (small + large), 0.25, 0.75);
  posts_bytes_ = static_cast<std::size_t>(share * static_cast<double>(cache_bytes));
  most_open_ = std::clamp<std::size_t>(large_count, 1, kMostOpen);
  options_.cache_bytes = (cache_bytes - posts_bytes_) / most_open_;
}

bool RasterPool::is_small(const RasterInfo& info) const {
  return bytes_as_floats(info) <= most_whole_bytes_;
}

std::shared_ptr<ChunkCache> RasterPool::posts() {
  const std::scoped_lock lock(mutex_);
  if (!posts_) posts_ = std::make_shared<ChunkCache>(posts_bytes_);
  return posts_;
}

// The source is closed again: it will not be asked for more. Its cache may hold what it decodes, as whole
// strips.
Result<ChunkCache::Chunk> RasterPool::read_whole(std::size_t source) {
  const RasterInfo& info = infos_[source];
  OpenOptions options = options_;
  options.cache_bytes = 4 * most_whole_bytes_;
  const auto raster = open_source(source, options);
  if (!raster) return raster.error();
  ChunkCache::Chunk posts(bytes_as_floats(info));
  const std::span<float> heights(reinterpret_cast<float*>(posts.data()), posts.size() / sizeof(float));
  const Status read = (*raster)->read_heights({0, 0, info.columns, info.rows}, heights);
  if (!read) return read.error();
  clamp_sea(info, heights);
  note_voids(source, heights);
  return posts;
}

Status RasterPool::read_heights(std::size_t source, const PostWindow& window, std::span<float> out) {
  const RasterInfo& info = infos_[source];
  if (!is_small(info)) {
    const auto raster = acquire(source);
    if (!raster) return raster.error();
    if (auto status = (*raster)->read_heights(window, out); !status) return status;
    clamp_sea(info, out);
    note_voids(source, out);
    return {};
  }
  assert(out.size() == static_cast<std::size_t>(window.columns * window.rows));
  const std::shared_ptr<ChunkCache> cache = posts();
  const auto whole = cache->get(source, [&] { return read_whole(source); });
  if (!whole) return whole.error();
  const std::size_t row_bytes = static_cast<std::size_t>(window.columns) * sizeof(float);
  for (std::int64_t r = 0; r < window.rows; ++r) {
    const auto from = static_cast<std::size_t>((window.row + r) * info.columns + window.column);
    std::memcpy(out.data() + r * window.columns, (*whole)->data() + from * sizeof(float), row_bytes);
  }
  return {};
}

Result<std::shared_ptr<const RasterSource>> RasterPool::acquire(std::size_t source) {
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const OpenSource& o) { return o.source == source; });
  if (found != open_.end()) {
    open_.splice(open_.begin(), open_, found);
    return open_.front().raster;
  }
  auto raster = open_source(source, options_);
  if (!raster) return raster.error();
  if (open_.size() >= most_open_) open_.pop_back();
  open_.push_front({source, std::move(*raster)});
  return open_.front().raster;
}

void RasterPool::close() {
  const std::scoped_lock lock(mutex_);
  open_.clear();
  posts_.reset();
}

}  // namespace cairn
