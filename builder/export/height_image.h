#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "builder/export/tiff_writer.h"
#include "cairn/height_tile.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Heights as other programs want them: posts on a grid, in metres.
struct HeightGrid {
  GeoGrid posts;  ///< west and north are those of the first post
  VerticalDatum datum = VerticalDatum::unknown;
  bool whole_metres = false;  ///< all heights are
};

/// Fills a row of posts with metres, a void NaN. Each row is asked for once, from the north.
using HeightRows = std::function<Status(int row, std::span<double> metres)>;

/// A tile's grid, and its samples as rows. REQUIRES: the tile outlives the rows.
HeightGrid grid_of(const HeightTile& tile, const TileId& id, const PackHeader& header);
HeightRows rows_of(const HeightTile& tile, const PackHeader& header);

/// Each writes one file beside its target and renames it when whole.

/// GeoTIFF, EPSG:4326, pixel-is-point, deflated; int16 where all heights are whole metres, else float32. The
/// nodata tag says -32768.
Status write_height_tiff(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows);

/// 16-bit grey PNG: 32768 + metres, rounded to whole metres; a void is 0.
Status write_height_png(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows);

/// SRTM's .hgt: big-endian int16, whole metres, a void -32768. The format has no header: other programs know
/// a cell by 1201² or 3601² posts and by a name such as N36E028.hgt.
Status write_height_hgt(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows);

}  // namespace cairn
