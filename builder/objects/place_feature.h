#pragma once

#include <nlohmann/json_fwd.hpp>

#include "builder/objects/place_files.h"
#include "cairn/status.h"

namespace cairn {

/// Hands over the places of a GeoJSON feature of points, or the area of one of polygons. docs/objects.md has
/// the properties.
Status read_feature(const nlohmann::json& feature, const PlaceVisitor& visitor);

}  // namespace cairn
