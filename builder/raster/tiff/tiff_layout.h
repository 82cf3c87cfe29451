#pragma once

#include "builder/raster/tiff/tiff_image.h"

namespace cairn {

/// The layout that a directory's tags declare. bad_data where it is none that cairn reads, naming the tag.
Result<TiffLayout> read_tiff_layout(const std::filesystem::path& path, const TiffHandle& handle);

/// Bytes of a row of a chunk as the file packs it: bits of samples padded to a whole byte.
std::int64_t packed_row_bytes(const TiffLayout& layout);

/// Unpacks samples of 1, 2 or 4 bits to bytes; REQUIRES layout.bits < 8 and whole rows in `packed`.
std::vector<std::byte> unpack_bits(const TiffLayout& layout, std::span<const std::byte> packed);

}  // namespace cairn
