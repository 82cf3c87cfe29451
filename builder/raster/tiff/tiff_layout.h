#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "builder/raster/raster_source.h"
#include "builder/raster/tiff/tiff_handle.h"
#include "cairn/status.h"

namespace cairn {

/// How a TIFF directory stores its pixels, checked against the file's size.
struct TiffLayout {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  int bands = 1;
  int bits = 8;                         ///< of a sample in the file
  SampleType type = SampleType::uint8;  ///< as samples are handed out; fewer than 8 bits come as uint8
  bool planar = false;                  ///< one plane a band, rather than the bands of a pixel together
  bool tiled = false;
  std::int64_t chunk_columns = 0;  ///< of a tile or strip
  std::int64_t chunk_rows = 0;
  std::uint16_t compression = 1;
  std::uint16_t photometric = 1;
  std::vector<std::uint16_t> extra_samples;
  std::vector<int> red_green_blue;    ///< the bands of these, from 0, where GDAL notes them; else empty
  std::vector<std::uint8_t> palette;  ///< R, G, B of each index, where the photometric is a palette

  std::int64_t chunks_across() const { return (columns + chunk_columns - 1) / chunk_columns; }
  std::int64_t chunks_down() const { return (rows + chunk_rows - 1) / chunk_rows; }
  int samples_together() const { return planar ? 1 : bands; }
};

/// The layout that a directory's tags declare. bad_data where it is none that cairn reads, naming the tag.
Result<TiffLayout> read_tiff_layout(const std::filesystem::path& path, const TiffHandle& handle);

/// Bytes of a row of a chunk as the file packs it: bits of samples padded to a whole byte.
std::int64_t packed_row_bytes(const TiffLayout& layout);

/// Unpacks samples of 1, 2 or 4 bits to bytes; REQUIRES layout.bits < 8 and whole rows in `packed`.
std::vector<std::byte> unpack_bits(const TiffLayout& layout, std::span<const std::byte> packed);

}  // namespace cairn
