#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/pack/bake_plan.h"
#include "cairn/build_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// All that decides what a unit's tiles are, as a hash: options, the tree around it, and the sources that
/// reach it. Units of one key have one result.
struct UnitKey {
  TileId unit;
  std::array<std::byte, 16> hash{};
  /// The sources that count in the key, by number in the pool, in the order in which they count.
  std::vector<std::uint32_t> sources;
};

/// The keys of all units, in the order of the trees' walks.
struct UnitKeys {
  std::vector<UnitKey> heights;
  std::vector<UnitKey> imagery;
};

/// `hashes` are those of files_of(options). Which DEMs have voids is what the mosaic's pool knows by now: of
/// a finished bake all that count.
UnitKeys unit_keys(const BakePlan& layers, const BuildOptions& options,
                   const std::vector<std::uint64_t>& hashes);

/// The area that the textures of a unit look at: the unit and the rims of its leaves, which are no wider than
/// its own would be. `tile_texels`: along a tile's side.
GeoBounds texture_area(const TileId& unit, int tile_texels);

}  // namespace cairn
