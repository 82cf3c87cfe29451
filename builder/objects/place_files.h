#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "builder/objects/object_place.h"
#include "builder/objects/scatter_rule.h"

namespace cairn {

/// Takes what a file of places has, one by one. An error ends the reading; its message says what is wrong
/// with the place or the area.
struct PlaceVisitor {
  std::function<Status(const ObjectPlace&)> place;
  std::function<Status(const ScatterArea&)> area;
};

/// Reads the objects of a file: CSV where its name ends in .csv or .txt, GeoJSON where it ends in .geojson or
/// .json, else what GDAL's vector drivers read. Errors begin with "FILE: line N", "FILE: feature N" or
/// "FILE: layer NAME: feature N".
Status read_places(const std::filesystem::path& file, const PlaceVisitor& visitor);

/// Reads a text of lines `lon,lat,model[,heading,scale,height,mode]`, of which the first names the columns.
Status read_places_csv(const std::filesystem::path& file, const PlaceVisitor& visitor);

/// Reads the points and polygons of a GeoJSON file.
Status read_places_geojson(const std::filesystem::path& file, const PlaceVisitor& visitor);

/// Reads the points and polygons of all layers of a file, in any CRS, through the module cairn-gdal.
Status read_places_gdal(const std::filesystem::path& file, const PlaceVisitor& visitor);

/// Returns the file and those beside it that belong to it, such as the .dbf of a shapefile.
std::vector<std::filesystem::path> files_of_places(const std::filesystem::path& file);

}  // namespace cairn
