#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Heights at places, from a pack: bilinear between the samples of the finest tile that covers the place,
/// edges included, so that a place on the outer border of what was baked has a height. Longitudes may have
/// any number of turns. Keeps a few decoded tiles, so that neighbouring places are cheap. Not thread-safe:
/// one sampler a thread.
class PackSampler {
 public:
  /// REQUIRES: the reader outlives the sampler.
  explicit PackSampler(const PackReader& reader, std::size_t cached_tiles = 16);
  ~PackSampler();
  PackSampler(PackSampler&&) noexcept;

  struct Height {
    double metres = 0;
    int level = 0;  ///< of the tile that gave it
  };

  /// nullopt where no tile covers the place or a sample that it needs is void, and where the latitude is no
  /// place on Earth. Only levels from `coarsest` to `finest` are asked. Errors are those of reading the tile.
  Result<std::optional<Height>> height_at(LonLat place, int finest = kMaxLevel, int coarsest = kMinLevel);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
