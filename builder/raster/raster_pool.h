#pragma once

#include <cstddef>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "builder/raster/raster_source.h"
#include "cairn/status.h"

namespace cairn {

/// The sources of a bake. What each says of itself is kept; the files are opened when they are read and
/// closed again, least recently used first, so that thousands of cells need neither thousands of descriptors
/// nor of caches. Safe to call from several threads.
class RasterPool {
 public:
  /// Opens every path once, to ask what it is. `cache_bytes` is shared by the sources that are open at a
  /// time.
  static Result<std::unique_ptr<RasterPool>> open(std::span<const std::filesystem::path> paths,
                                                  const OpenOptions& options);

  std::size_t size() const { return infos_.size(); }
  const RasterInfo& info(std::size_t source) const { return infos_[source]; }

  /// The source, opened if it was not. It stays usable for as long as the caller holds it.
  Result<std::shared_ptr<const RasterSource>> acquire(std::size_t source);

  /// Closes all files and drops their caches, but for those in use; acquire() opens them again.
  void close();

 private:
  RasterPool() = default;

  struct OpenSource {
    std::size_t source;
    std::shared_ptr<const RasterSource> raster;
  };

  std::vector<RasterInfo> infos_;
  OpenOptions options_;
  std::size_t most_open_ = 1;
  std::mutex mutex_;
  std::list<OpenSource> open_;  // guarded by mutex_; most recently used first
};

}  // namespace cairn
