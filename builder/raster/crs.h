#pragma once

#include <string>
#include <string_view>

#include "builder/raster/georeference.h"

namespace cairn {

/// Sets the CRS of a georeference by its EPSG code, where it is one that cairn knows: geographic on WGS84,
/// NAD83, ETRS89 or another datum within about a metre of WGS84; UTM on those; Web Mercator. Returns whether.
bool set_crs(Georeference& georeference, int epsg);

/// The same for the geodetic datum's code alone (6326 is WGS84's): whether it lies within about a metre of
/// WGS84.
bool is_near_wgs84(int geodetic_datum);

/// Sets UTM. Returns false where the zone is none.
bool set_utm(Georeference& georeference, int zone, bool north);

/// Sets a CRS that cairn does not compute itself, by its definition ("EPSG:2154", WKT). place_raster() finds
/// it.
void set_other_crs(Georeference& georeference, std::string definition);

/// Metres of a vertical unit by its EPSG code (9001 metre, 9002 foot, 9003 US survey foot), or 0.
double metres_of_unit(int epsg_unit);

/// The same by the unit's name as files spell it: "m", "metre", "ft", "US survey foot" …; "" is the metre.
double metres_of_unit(std::string_view name);

}  // namespace cairn
