#pragma once

#include <filesystem>
#include <vector>

#include "cairn/drape.h"
#include "cairn/status.h"

namespace cairn::viewer {

/// Reads the lines and points of GeoJSON (RFC 7946; of polygons their rings) and GPX (routes, tracks,
/// waypoints) files, one after the other. Colours and widths are those of a feature's properties `stroke`,
/// `stroke-width` and `marker-color` (simplestyle 1.1.0), else each file has one of its own. Heights are
/// left out: all lies on the ground. bad_data names the file and the place in it.
Result<Drape> read_drapes(const std::vector<std::filesystem::path>& files);

}  // namespace cairn::viewer
