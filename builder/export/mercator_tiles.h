#pragma once

#include <cstdint>

#include "cairn/geo.h"

namespace cairn {

/// A tile of the Web Mercator scheme (EPSG:3857): 2^zoom columns from 180°W and rows from the NORTH.
struct MercatorTile {
  int zoom = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
};

/// The latitude where the scheme ends.
inline constexpr double kMercatorLimit = 85.0511287798066;

/// The place at a part of the tile's width from its west and of its height from its NORTH.
LonLat mercator_place(const MercatorTile& tile, double right, double down);

/// The latitude's part of the world's height from the north, 0 to 1 within the scheme.
double mercator_row(double lat);

GeoBounds mercator_bounds(const MercatorTile& tile);

/// The tile's number in a PMTiles archive: all coarser zooms, then its place on a Hilbert curve.
std::uint64_t pmtiles_id(const MercatorTile& tile);

}  // namespace cairn
