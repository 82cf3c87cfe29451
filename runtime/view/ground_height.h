#pragma once

#include <optional>

#include "cairn/geo.h"
#include "cairn/height_tile.h"
#include "cairn/pack_reader.h"
#include "cairn/tile_id.h"

namespace cairn {

/// Returns the height of the tile's bilinear surface at a place, in metres; nullopt if a sample that it needs
/// is void. REQUIRES: the place, its longitude wrapped, lies in the tile `id`, to which the samples belong.
std::optional<double> ground_height_m(const HeightTile& tile, const TileId& id, double quantum_m,
                                      LonLat place);

/// Returns a height in metres that no ground of the pack exceeds, that of tiles with their errors included;
/// minus infinity where it has no heights. Reads the index of the coarsest level.
double highest_ground_m(const PackReader& pack);

}  // namespace cairn
