#pragma once

namespace cairn {

/// Degrees on WGS84; longitude east of Greenwich, latitude north of the equator.
struct LonLat {
  double lon = 0;
  double lat = 0;
};

/// A closed rectangle in degrees, west <= east and south <= north. A region across the antimeridian has
/// east > 180 (so 170…190 is twenty degrees wide).
struct GeoBounds {
  double west = 0;
  double south = 0;
  double east = 0;
  double north = 0;

  double width() const { return east - west; }
  double height() const { return north - south; }
  bool contains(LonLat p) const { return p.lon >= west && p.lon <= east && p.lat >= south && p.lat <= north; }
  bool touches(const GeoBounds& o) const {
    return west <= o.east && o.west <= east && south <= o.north && o.south <= north;
  }
};

}  // namespace cairn
