#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <span>

#include "builder/raster/colour_encoding.h"
#include "builder/raster/io/scratch_bytes.h"
#include "builder/raster/raster_source.h"

namespace cairn {

/// What an image file that decodes from top to bottom only (PNG, JPEG) says of itself. One band is grey, two
/// grey and alpha, three RGB, four RGB and alpha; colours are unsigned, of 8 or 16 bits, heights of any type.
struct ScanlineHeader {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  int bands = 1;
  SampleType type = SampleType::uint8;
};

/// Takes rows from the top, in this machine's byte order.
using RowSink = std::function<Status(std::span<const std::byte>)>;

/// Decodes the file at `path`, whose header was read before, and hands every row to the sink.
using DecodeRows = Status (*)(const std::filesystem::path& path, const ScanlineHeader& header,
                              const RowSink& sink);

/// A raster over such a file, placed by what lies beside it or by the options. The first read decodes the
/// whole image, to memory or, past options.cache_bytes, to a temporary file.
Result<std::unique_ptr<RasterSource>> open_scanline_raster(const char* format,
                                                           const std::filesystem::path& path,
                                                           const ScanlineHeader& header, DecodeRows decode,
                                                           const OpenOptions& options);

}  // namespace cairn
