#pragma once

#include <cstddef>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Returns the indices of the scene's tiles to draw: all, or with view.cull those that may be visible.
std::vector<std::size_t> tiles_in_view(const LodScene& scene, const LodView& view);

}  // namespace cairn
