#pragma once

#include <cstdint>
#include <vector>

#include "runtime/lab/lab_terrain.h"
#include "runtime/lod/lod_method.h"

namespace cairn {

/// The cost of a scene, and how much of it the view needs.
struct SceneUse {
  std::vector<TileId> sources;  ///< ascending, each once
  std::uint64_t triangles = 0;  ///< of every sample of every area
  std::uint64_t useful_tiles = 0;
  std::uint64_t decoded_bytes = 0;
  std::uint64_t loaded_bytes = 0;
  std::uint64_t useful_loaded_bytes = 0;
};

/// A source is of use if a part of it is visible where its parent's geometric error projects above a quarter
/// of a pixel, or if it has no parent.
SceneUse use_of(const LabTerrain& terrain, const LodScene& scene, const ViewState& view);

}  // namespace cairn
