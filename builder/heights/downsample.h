#pragma once

#include "cairn/height_tile.h"

namespace cairn {

/// Nested levels: a coarser tile's sample is the finer tile's sample at the same place, every second one.

/// A tile of which every sample is void, to take in its children.
HeightTile empty_parent(int tile_size);

/// Copies every second sample of the child into its quadrant (bit 0 east, bit 1 north) of the parent. A
/// sample that two children share keeps the value of the one that has it.
void take_child(const HeightTile& child, int quadrant, HeightTile& parent);

/// Once all children are in: drops a mask without voids, and levels what is void.
void close_parent(HeightTile& parent);

/// The largest distance, in quanta, between the tile's samples and the surface that keeps only every second
/// one; where that surface has a hole, nothing is measured.
double decimation_error(const HeightTile& tile);

}  // namespace cairn
