#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Returns the colours of a pack's imagery at places: the texel of the finest tile that covers the place.
/// Longitudes may have any number of turns. Keeps a few decoded tiles, so that neighbouring places are cheap.
/// Not thread-safe: one sampler a thread.
class ImagerySampler {
 public:
  using Colour = std::array<std::uint8_t, 4>;  ///< RGBA in sRGB

  /// REQUIRES: the reader outlives the sampler; cached_tiles >= 1.
  explicit ImagerySampler(const PackReader& reader, std::size_t cached_tiles = 16);
  ~ImagerySampler();
  ImagerySampler(ImagerySampler&&) noexcept;

  /// Transparent black where no tile of level `finest` or a coarser one covers the place, and where the
  /// latitude is no place on Earth. Errors are those of reading the tile.
  Result<Colour> colour_at(LonLat place, int finest = kMaxLevel);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
