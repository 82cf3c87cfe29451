#pragma once

#include <cstddef>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// The numbers of the tiles to draw: all, or those that the view may see where it culls.
std::vector<std::size_t> tiles_in_view(const LodScene& scene, const LodView& view);

}  // namespace cairn
