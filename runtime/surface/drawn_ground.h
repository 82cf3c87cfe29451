#pragma once

#include <optional>
#include <span>

#include "cairn/geo.h"
#include "cairn/render_list.h"
#include "runtime/surface/lod_transition.h"

namespace cairn {

/// The height of the ground at a place as the renderer draws it at full detail: of the triangles between the
/// samples, whose diagonals run from south-west to north-east. Terrain::ground_height_m() gives the bilinear
/// surface, which leaves these by a quarter of a cell's twist: metres in coarse mountains, so that an eye
/// just above it may be under what is drawn. nullopt where the list shows no heights, or a void.
std::optional<double> drawn_ground_m(const RenderList& list, double quantum_m, LonLat place);

/// The same with no more detail than a frame shows.
std::optional<double> drawn_ground_m(std::span<const ShownTile> tiles, double quantum_m, LonLat place);

}  // namespace cairn
