#pragma once

#include <vector>

#include "cairn/height_tile.h"

namespace cairn {

/// Returns, row by row, the largest vertical distance, in quanta, of samples from the triangles bisected at a
/// vertex.
///
/// The triangles are those of the hierarchy of RqtSteps: a vertex is the base of two, on the tile's border of
/// one. A triangle covers the samples inside it and on its edges (Intel 2012: "the maximum vertical distance
/// of all vertices covered by the triangle to the triangle plane"). The error is 0 at the tile's corners.
/// Void samples count with their filler.
///
/// Equal on every machine; in single precision, at most 2^-20 of the tile's range too large or too small.
/// REQUIRES: tile.size = 2^n + 1.
std::vector<float> bisection_errors(const HeightTile& tile, bool rising);

}  // namespace cairn
