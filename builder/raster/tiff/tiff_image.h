#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/io/input_file.h"
#include "builder/raster/io/scratch_bytes.h"
#include "builder/raster/raster_source.h"
#include "builder/raster/tiff/tiff_handle.h"
#include "builder/raster/tiff/tiff_layout.h"
#include "cairn/status.h"

namespace cairn {

/// The pixels of one directory of a TIFF or BigTIFF, in their own type, without geography. Safe for several
/// threads at once. Plain strips and tiles are read straight from the file; packed ones, and plain tiles of
/// colours, through a cache; a strip too large for the cache is unpacked once, row by row, to scratch.
class TiffImage {
 public:
  /// Takes over the handle on the directory, to decode with.
  static Result<std::unique_ptr<TiffImage>> open(const std::filesystem::path& path,
                                                 std::unique_ptr<TiffHandle> handle, std::uint16_t directory,
                                                 std::size_t cache_bytes);

  const TiffLayout& layout() const { return layout_; }

  /// Some pixels of one row of a window, relative to its corner. `samples` are in this machine's byte order,
  /// samples_together() of them a pixel; null where the file stores nothing there (a sparse file).
  struct Run {
    std::int64_t column = 0;
    std::int64_t row = 0;
    std::int64_t count = 0;
    const std::byte* samples = nullptr;
  };
  /// Calls back for runs that together make up the window, in one plane (0 where not planar).
  Status visit(const PostWindow& window, int plane, const std::function<void(const Run&)>& run) const;

 private:
  struct Part;  // of a window, within one chunk

  TiffImage(std::filesystem::path path, InputFile file, std::uint16_t directory, std::size_t cache_bytes);
  Status read_chunk_table(const TiffHandle& handle);
  Status visit_stored(const Part& part, const std::function<void(const Run&)>& run) const;
  Status visit_decoded(const Part& part, const std::function<void(const Run&)>& run) const;
  Status visit_scratch(const Part& part, const std::function<void(const Run&)>& run) const;
  Result<ChunkCache::Chunk> read_chunk(std::int64_t chunk, std::int64_t rows) const;
  Result<ChunkCache::Chunk> decode_chunk(std::int64_t chunk, std::int64_t rows) const;
  Status unpack_to_scratch() const;
  std::string place_of_chunk(std::int64_t chunk) const;

  std::filesystem::path path_;
  InputFile file_;
  TiffLayout layout_;
  bool stored_ = false;   // neither packed nor of odd bits: bytes of the file are samples
  bool swapped_ = false;  // in the other byte order, which matters to stored_ only
  bool kept_ = false;     // stored_, but windows of colours overlap: read once and cached
  bool through_scratch_ = false;
  std::vector<std::uint64_t> offsets_;
  std::vector<std::uint64_t> byte_counts_;
  mutable TiffHandlePool handles_;
  mutable ChunkCache cache_;
  mutable std::once_flag scratch_once_;
  mutable Status scratch_status_;
  mutable ScratchBytes scratch_;
};

}  // namespace cairn
