#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// The part of a tile inside the world: columns 0 to `east` and rows 0 to `north`, both at most N−1.
/// Only tiles of L < −3 (in x) or L < −2 (in y) may end before N−1; the rest is void. Column `east` of the
/// last tile of a row is the antimeridian, which is column 0 of the first.
struct WorldExtent {
  int east = 0;
  int north = 0;
};
WorldExtent world_extent(const TileId& id, int tile_size);

/// Digests of what a tile has in common with others, small enough to keep for every tile of a pack.
/// Equal samples, voids included, give equal digests, whatever the voids' fillers. Unequal samples give equal
/// digests with a probability of 2^-64.
struct TileDigest {
  std::uint64_t west = 0, east = 0, south = 0, north = 0;  ///< of the edges; east at the WorldExtent
  std::int64_t south_west = 0, south_east = 0, north_west = 0, north_east = 0;  ///< the corner samples
  std::array<std::uint64_t, 4> quadrants{};  ///< of the samples that child 0…3 has at its even places
  std::uint64_t even = 0;  ///< of the samples that the parent has: the even columns and rows
};
TileDigest digest_of(const HeightTile& tile, const TileId& id);

/// The value of a void sample where samples are compared; others have their height in quanta.
inline constexpr std::int64_t kVoidSample = INT64_MAX;

enum class Edge { west, east, south, north };

/// Return the samples that the digests are made of, in ascending columns, then rows.
std::vector<std::int64_t> edge_samples(const HeightTile& tile, const TileId& id, Edge edge);
std::vector<std::int64_t> quadrant_samples(const HeightTile& tile, int quadrant);
std::vector<std::int64_t> even_samples(const HeightTile& tile);

}  // namespace cairn
