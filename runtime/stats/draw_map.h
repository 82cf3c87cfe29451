#pragma once

#include <string>

#include "runtime/scene/scene_map.h"

namespace cairn {

/// Returns a scene map as SVG, north up, in the manner of Melkisetoğlu 2005, figures 6.2.2 to 6.2.9.
/// Finer tiles are darker, the camera's tile is black. REQUIRES: the map is not empty and does not cross the
/// antimeridian.
std::string draw_map(const SceneMap& map, const TileId& eye, std::string_view title);

}  // namespace cairn
