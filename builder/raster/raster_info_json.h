#pragma once

#include <nlohmann/json_fwd.hpp>

#include "builder/raster/raster_source.h"
#include "cairn/status.h"

namespace cairn {

/// What a raster says of itself, so that its place and kind are known where the file is not: every number is
/// restored to the bit. What the user says of it is left out.
nlohmann::json to_json(const RasterInfo& info);

/// The inverse. Finds the transform of a CRS that cairn does not compute itself. bad_data names what is
/// missing or of the wrong type.
Result<RasterInfo> raster_info_from(const nlohmann::json& json);

}  // namespace cairn
