#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "cairn/geo.h"
#include "cairn/height_tile.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Tiles of heights, wherever they are.
struct GroundTiles {
  std::function<std::optional<IndexEntry>(const TileId&)> find;
  std::function<Result<HeightTile>(const IndexEntry&)> read;
  int tile_size = 513;
};

/// Returns heights at places: bilinear between the samples of the finest tile that covers the place.
/// PackSampler says the rules. Not thread-safe.
class GroundSampler {
 public:
  GroundSampler(GroundTiles tiles, std::size_t cached_tiles);
  ~GroundSampler();
  GroundSampler(GroundSampler&&) noexcept;

  struct Height {
    double quanta = 0;
    IndexEntry tile;  ///< that it comes from
  };

  /// Returns nullopt where no tile covers the place or a sample that it needs is void. Only tiles of these
  /// levels are used. REQUIRES: a finite longitude, a latitude of the Earth.
  Result<std::optional<Height>> height_at(LonLat place, int finest, int coarsest);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
