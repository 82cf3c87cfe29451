#pragma once

#include <cstddef>
#include <optional>

#include "builder/raster/sample_type.h"

namespace cairn {

/// How a file writes a height: metres = sample · scale + offset.
struct HeightEncoding {
  SampleType type = SampleType::int16;
  bool swapped = false;                         ///< the other byte order than this machine's
  std::optional<double> nodata = std::nullopt;  ///< compared with the sample, before scale and offset
  double scale = 1;
  double offset = 0;

  /// Whether every height is a whole number of metres.
  bool whole_metres() const;
};

/// Heights beyond this, either way, are no place on Earth: voids (an untagged FLT_MAX, say).
inline constexpr double kImpossibleHeight = 1e6;

/// Converts `count` samples that lie `stride` samples apart to metres. Voids become NaN: -32768, -32767,
/// -9999, the nodata value (in floating point within its rounding), NaN, infinities and impossible heights.
void decode_heights(const HeightEncoding& encoding, const std::byte* samples, std::size_t count,
                    std::size_t stride, float* metres);

/// Reverses the bytes of each of `count` samples of `sample_bytes` (1, 2, 4 or 8) in place.
void swap_bytes(std::byte* samples, std::size_t count, std::size_t sample_bytes);

}  // namespace cairn
