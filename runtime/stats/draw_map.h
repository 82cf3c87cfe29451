#pragma once

#include <string>

#include "runtime/scene/scene_map.h"

namespace cairn {

/// A scene map of several levels as SVG, north up, like [4, figures 6.2.2–6.2.9]: finer tiles are darker, the
/// eye's tile is black. REQUIRES: the map is not empty and does not cross the antimeridian.
std::string draw_map(const SceneMap& map, const TileId& eye, std::string_view title);

}  // namespace cairn
