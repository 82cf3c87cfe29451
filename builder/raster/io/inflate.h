#pragma once

#include <cstdint>

#include "builder/raster/io/input_file.h"
#include "builder/raster/io/scratch_bytes.h"
#include "cairn/status.h"

namespace cairn {

enum class DeflateWrapping { gzip, none };

/// Inflates `count` bytes of the file from `offset` on (RFC 1951, with RFC 1952's header and checksum for
/// gzip) onto the end of `out`. bad_data where the stream is damaged or cut, or does not give exactly
/// `expected_bytes`; it never gives more, whatever the stream says.
Status inflate(const InputFile& file, std::uint64_t offset, std::uint64_t count, DeflateWrapping wrapping,
               std::uint64_t expected_bytes, ScratchBytes& out);

}  // namespace cairn
