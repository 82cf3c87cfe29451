#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/raster_source.h"
#include "cairn/status.h"

namespace cairn {

/// The sources of a bake. What each says of itself is kept; the files are opened when they are read and
/// closed again, least recently used first, so that thousands of cells need neither thousands of descriptors
/// nor of caches. Safe to call from several threads.
class RasterPool {
 public:
  enum class Content { heights, colours };

  /// Opens every path once, on all threads of the caller's arena, to ask what it is. `options.cache_bytes`
  /// is shared by all that is kept of the sources, until set_cache_bytes(). The error is that of the first
  /// path that has one.
  static Result<std::unique_ptr<RasterPool>> open(std::span<const std::filesystem::path> paths,
                                                  const OpenOptions& options, Content content);

  /// A pool of sources that are known already, of which no file is opened before it is read. Those that are
  /// not `available` can be asked what they are and not be read.
  static std::unique_ptr<RasterPool> describe(std::vector<RasterInfo> infos, std::vector<bool> available,
                                              const OpenOptions& options, Content content);

  /// What may be kept of all sources together. Drops what is kept. Not while other threads read.
  void set_cache_bytes(std::size_t cache_bytes);

  std::size_t size() const { return infos_.size(); }
  const RasterInfo& info(std::size_t source) const { return infos_[source]; }

  /// Heights as RasterSource::read_heights() gives them, none below the source's sea clamp. A small source is
  /// read whole, so that it is opened and decoded once for all windows that share it, and its posts are kept
  /// while there is room for them. REQUIRES: the content is heights.
  Status read_heights(std::size_t source, const PostWindow& window, std::span<float> out);

  /// Whether a void was among the heights that read_heights() has given of the source, or may have been
  /// among those that expect_voids() speaks of.
  bool has_voids(std::size_t source) const { return has_voids_[source] != 0; }
  void expect_voids(std::size_t source) { has_voids_[source] = 1; }

  /// The source, opened if it was not. It stays usable for as long as the caller holds it.
  Result<std::shared_ptr<const RasterSource>> acquire(std::size_t source);

  /// Closes all files and drops what is kept of them, but for what is in use; it is read again when it is
  /// asked for.
  void close();

 private:
  RasterPool() = default;

  struct OpenSource {
    std::size_t source;
    std::shared_ptr<const RasterSource> raster;
  };

  Result<std::unique_ptr<RasterSource>> open_source(std::size_t source, const OpenOptions& options) const;
  void note_voids(std::size_t source, std::span<const float> heights);
  Status ask_all(std::span<const std::filesystem::path> paths, Content content);
  bool is_small(const RasterInfo& info) const;
  Result<ChunkCache::Chunk> read_whole(std::size_t source);
  std::shared_ptr<ChunkCache> posts();

  Content content_ = Content::heights;
  std::vector<RasterInfo> infos_;
  std::vector<bool> available_;  // empty where all are
  std::vector<std::atomic<char>> has_voids_;
  OpenOptions options_;
  std::size_t most_open_ = 1;
  std::size_t most_whole_bytes_ = 0;  // as floats, of a source that is read whole
  std::size_t posts_bytes_ = 0;       // of all such that are kept
  std::mutex mutex_;
  std::list<OpenSource> open_;         // guarded by mutex_; most recently used first
  std::shared_ptr<ChunkCache> posts_;  // the pointer is guarded by mutex_; by source
};

}  // namespace cairn
