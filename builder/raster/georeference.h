#pragma once

#include <memory>
#include <string>

#include "builder/raster/crs_transform.h"
#include "cairn/geo.h"

namespace cairn {

/// Where the posts of a raster lie. Post (column, row) has the CRS coordinate x = x0 + column·dx +
/// row·x_per_row, y = y0 + column·y_per_column + row·dy: the place of the post itself, so for a pixel-is-area
/// raster the pixel's centre.
struct Georeference {
  enum class Crs {
    geographic,    ///< degrees; on the Earth WGS84 or NAD83, which differ by about a metre: cairn ignores it
    utm,           ///< metres, transverse Mercator on WGS84, k0 = 0.9996
    web_mercator,  ///< metres, EPSG:3857
    other,         ///< by `transform`, in the CRS's own unit
  };
  Crs crs = Crs::geographic;
  int utm_zone = 0;  ///< 1…60
  bool utm_north = true;
  double x0 = 0;
  double y0 = 0;
  double dx = 1;
  double dy = -1;           ///< negative where row 0 is the northernmost, as in most files
  double x_per_row = 0;     ///< other than 0 where the raster is turned or sheared
  double y_per_column = 0;  ///< likewise
  /// The factor between the tangents of a place's latitude and of the one that the CRS gives: other than 1
  /// where that is planetocentric, or on another ellipsoid than the body's.
  double latitude_factor = 1;
  std::string definition = {};  ///< of another CRS, as open_crs() takes it
  std::shared_ptr<const CrsTransform> transform =
      nullptr;  ///< of another CRS, once place_raster() has found it

  /// Whether columns run along x and rows along y.
  bool is_straight() const { return x_per_row == 0 && y_per_column == 0; }

  /// Whether columns are meridians and rows parallels of the pack's own latitude, evenly spaced.
  bool is_lattice() const {
    return crs == Crs::geographic && is_straight() && dx > 0 && latitude_factor == 1;
  }

  /// Whether coordinates of both have one meaning.
  bool has_crs_of(const Georeference& other) const;

  /// The place of a post; fractional columns and rows are places between posts. Infinite where the CRS has
  /// none.
  LonLat place_of(double column, double row) const;

  struct ColumnRow {
    double column = 0;
    double row = 0;
  };
  /// The inverse. For geographic rasters longitudes are taken as given, not wrapped.
  ColumnRow post_at(LonLat place) const;

  /// The CRS coordinate of a post.
  LonLat coordinate_of(double column, double row) const {
    return {x0 + column * dx + row * x_per_row, y0 + column * y_per_column + row * dy};
  }
  /// The post at a CRS coordinate.
  ColumnRow post_at_coordinate(LonLat xy) const;
};

}  // namespace cairn
