#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "builder/coarse_mesh.h"
#include "builder/linear_image.h"
#include "builder/pixel_taps.h"
#include "builder/texture_encode.h"

namespace cairn {

/// One texel in linear light: R, G, B times alpha, and alpha, 0…65535.
using WideTexel = float __attribute__((vector_size(16)));

/// A rectangle of pixels in linear light.
struct WidePixels {
  const WideTexel* pixels = nullptr;  ///< the one at (column, row), rows from the north
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 0;
};

/// The inner loops of resampling, for one instruction set. All give the same bits. Sums are clamped, since a
/// cubic overshoots: alpha to 0…65535, colours to 0…alpha.
struct TexelRows {
  /// out[t] = Σ weights[t·count + i] · pixels[first[t] - column + i]; `pixels` is a row from `column` on.
  void (*filter)(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps, WideTexel* out);
  /// out[t] = Σ weights[i] · rows[i][t], clamped and rounded.
  void (*combine)(std::span<const WideTexel* const> rows, const float* weights, std::size_t width,
                  LinearTexel* out);
  /// out[t] = the cubic (PixelTaps, texels no larger than pixels) at places[t], clamped and rounded; places
  /// are columns and rows of pixels, 0 the first one's centre. REQUIRES: each place is > -2, and the 4×4
  /// pixels around it lie in the rectangle.
  void (*interpolate)(const WidePixels& pixels, std::span<const PlanePoint> places, LinearTexel* out);
  /// out[t] = the mean of texels 2t and 2t+1 of two rows, halves rounded up.
  void (*halve)(const LinearTexel* north, const LinearTexel* south, std::size_t width, LinearTexel* out);
};

const TexelRows& texel_rows(KernelIsa isa);
const TexelRows& texel_rows();  ///< for the CPU at hand

/// A sum of pixels, clamped and rounded as TexelRows does.
LinearTexel to_linear_texel(WideTexel sum);

}  // namespace cairn
