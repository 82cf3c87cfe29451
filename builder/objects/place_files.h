#pragma once

#include <filesystem>
#include <functional>

#include "builder/objects/object_place.h"

namespace cairn {

/// Takes the objects of a file one by one. An error ends the reading; its message says what is wrong with the
/// place.
using TakePlace = std::function<Status(const ObjectPlace&)>;

/// Reads the objects of a file: GeoJSON where its name ends in .geojson or .json, else CSV. Errors begin with
/// "FILE: line N" or "FILE: feature N".
Status read_places(const std::filesystem::path& file, const TakePlace& take);

/// Reads a text of lines `lon,lat,model[,heading,scale,height,mode]`, of which the first names the columns.
Status read_places_csv(const std::filesystem::path& file, const TakePlace& take);

/// Reads the points of a GeoJSON file; their properties are the columns of the CSV.
Status read_places_geojson(const std::filesystem::path& file, const TakePlace& take);

}  // namespace cairn
