#pragma once

#include <filesystem>

#include "builder/raster/io/byte_sink.h"

namespace cairn {

/// Hands on what a gzip file holds (RFC 1952, any number of members). bad_data where the file is no gzip
/// file, is damaged or is cut off, and the sink's own error where that gives one. Checksums are verified.
Status unpack_gzip(const std::filesystem::path& path, const ByteSink& sink);

}  // namespace cairn
