#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Returns heights at places: bilinear between the samples of the finest tile that covers the place.
/// A tile covers its edges, so a place on the outer border of what was baked has a height. Longitudes may
/// have any number of turns. A few decoded tiles are kept, so that neighbouring places are cheap. Not
/// thread-safe: use one sampler per thread.
class PackSampler {
 public:
  /// REQUIRES: the reader outlives the sampler.
  explicit PackSampler(const PackReader& reader, std::size_t cached_tiles = 16);
  ~PackSampler();
  PackSampler(PackSampler&&) noexcept;

  struct Height {
    double metres = 0;
    int level = 0;      ///< of the tile that it comes from
    float error_m = 0;  ///< geometric error of that tile
  };

  /// Returns nullopt where no tile covers the place, where a sample that it needs is void, and where the
  /// latitude is beyond a pole. Only levels from `coarsest` to `finest` are used. Errors are those of reading
  /// the tile.
  Result<std::optional<Height>> height_at(LonLat place, int finest = kMaxLevel, int coarsest = kMinLevel);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
