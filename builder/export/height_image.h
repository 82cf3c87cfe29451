#pragma once

#include <filesystem>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// A tile as other programs want it: metres, rows from NORTH to south, a void NaN, its place.
struct HeightImage {
  int size = 0;                ///< posts along a side
  std::vector<double> metres;  ///< size·size
  double west = 0;             ///< degrees, of the first column of posts
  double north = 0;            ///< degrees, of the first row of posts
  double spacing = 0;          ///< degrees between posts
  VerticalDatum datum = VerticalDatum::unknown;
};
HeightImage image_of(const HeightTile& tile, const TileId& id, const PackHeader& header);

/// Each writes one file beside its target and renames it when whole.

/// GeoTIFF, EPSG:4326, pixel-is-point, deflated; int16 where all heights are whole metres, else float32. The
/// nodata tag says -32768.
Status write_height_tiff(const std::filesystem::path& path, const HeightImage& image);

/// 16-bit grey PNG: 32768 + metres, rounded to whole metres; a void is 0.
Status write_height_png(const std::filesystem::path& path, const HeightImage& image);

/// SRTM's .hgt: big-endian int16, whole metres, a void -32768; size² posts.
Status write_height_hgt(const std::filesystem::path& path, const HeightImage& image);

}  // namespace cairn
