#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "builder/export/export_format.h"
#include "builder/export/mercator_tiles.h"
#include "builder/export/pmtiles_writer.h"

// What the exports to PMTiles archives share.

namespace cairn {

/// One finished tile.
struct PmtilesTile {
  std::vector<std::byte> bytes;  ///< empty where there is nothing to show
  double measure = 0;            ///< what was measured of it; a zoom has the largest
};

/// Which tiles an archive has and what is in them.
struct PmtilesPlan {
  PmtilesInfo::TileType type = PmtilesInfo::TileType::png;
  int min_zoom = 0;
  int max_zoom = 0;
  GeoBounds bounds;
  std::string identity;  ///< a line that tells this export from others
  std::function<bool(const MercatorTile&)> has;
  /// Makes tiles that lie beside each other; any number of threads call it.
  std::function<Result<std::vector<PmtilesTile>>(std::span<const MercatorTile>)> make;
  /// The archive's metadata, JSON, once all tiles are measured.
  std::function<std::string(const std::vector<ExportLevel>&)> metadata;
  /// Whether what was measured may be delivered.
  std::function<Status(const std::vector<ExportLevel>&)> check;
};

inline constexpr int kMostZoom = 22;

/// What is added to degrees so that bounds meet a tile on the other side of the antimeridian.
inline constexpr double kTurns[] = {-360, 0, 360};

/// Reads the options' zooms over the plan's. usage where there are no such zooms.
Status choose_zooms(const ExportOptions& options, PmtilesPlan& plan);

/// The bounds within the scheme. Across the antimeridian they are the whole way round: an archive knows no
/// others.
GeoBounds bounds_of_archive(GeoBounds bounds);

/// Writes the archive to the options' target and returns a level for each zoom that has tiles; its
/// `max_error_m` is the largest measure. failed where there is no tile.
Result<std::vector<ExportLevel>> write_pmtiles(const PmtilesPlan& plan, const ExportOptions& options,
                                               const ProgressCallback& progress);

}  // namespace cairn
