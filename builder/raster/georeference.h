#pragma once

#include "cairn/geo.h"

namespace cairn {

/// Where the posts of a raster lie. Post (column, row) has the CRS coordinate x = x0 + column·dx, y = y0 +
/// row·dy: the place of the post itself, so for a pixel-is-area raster the pixel's centre. No rotation.
struct Georeference {
  enum class Crs {
    geographic,    ///< degrees, WGS84 or NAD83 (they differ by about a metre, which cairn ignores)
    utm,           ///< metres, transverse Mercator on WGS84, k0 = 0.9996
    web_mercator,  ///< metres, EPSG:3857
  };
  Crs crs = Crs::geographic;
  int utm_zone = 0;  ///< 1…60
  bool utm_north = true;
  double x0 = 0;
  double y0 = 0;
  double dx = 1;
  double dy = -1;  ///< negative where row 0 is the northernmost, as in most files

  /// The place of a post; fractional columns and rows are places between posts.
  LonLat place_of(double column, double row) const;

  struct ColumnRow {
    double column = 0;
    double row = 0;
  };
  /// The inverse. For geographic rasters longitudes are taken as given, not wrapped.
  ColumnRow post_at(LonLat place) const;
};

}  // namespace cairn
