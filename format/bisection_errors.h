#pragma once

#include <vector>

#include "cairn/height_tile.h"

namespace cairn {

/// How far, at most, the samples of a tile are from the triangles that are bisected at a vertex, vertically
/// and in quanta; row-major like the samples. The triangles are those of the hierarchy of RqtSteps: a vertex
/// is the base of two, on the tile's border of one, and a triangle covers the samples inside it and on its
/// edges [3: "the maximum vertical distance of all vertices covered by the triangle to the triangle plane"].
/// 0 at the tile's corners. What a void sample holds counts like any other.
///
/// The same on every machine. In single precision: at most 2^-20 of the tile's range too large or too small.
/// REQUIRES: tile.size = 2^n + 1. About 18 operations a sample and level of the hierarchy.
std::vector<float> bisection_errors(const HeightTile& tile, bool rising);

}  // namespace cairn
