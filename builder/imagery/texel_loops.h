#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "builder/imagery/kernels/kernels.h"
#include "builder/imagery/pixel_taps.h"
#include "builder/resample/projection_mesh.h"
#include "builder/texture_encode/texture_encode.h"

namespace cairn {

/// One texel in linear light: R, G, B times alpha, and alpha, in steps of 1/65535. So averages need no
/// weights, and what is transparent never bleeds.
using LinearTexel = std::array<std::uint16_t, 4>;

/// The inner loops of resampling, for one instruction set. All give the same bits. Sums are clamped, since a
/// cubic overshoots: alpha to 0…65535, colours to 0…alpha.
class TexelLoops {
 public:
  /// REQUIRES: the CPU has it.
  explicit TexelLoops(KernelIsa isa) : kernels_(kernels_for(isa)) {}

  /// out[t] = Σ weights[t·count + i] · pixels[first[t] - column + i]; `pixels` is a row from `column` on.
  void filter(const FloatTexel* pixels, std::int64_t column, const PixelTaps& taps, FloatTexel* out) const;
  /// out[t] = Σ weights[i] · rows[i][t], clamped and rounded.
  void combine(std::span<const FloatTexel* const> rows, const float* weights, std::size_t width,
               LinearTexel* out) const;
  /// out[t] = the cubic (PixelTaps, texels no larger than pixels) at places[t], clamped and rounded; places
  /// are columns and rows of pixels, 0 the first one's centre. REQUIRES: each place is > -2 and < 2^31 - 4,
  /// and the 4×4 pixels around it lie in the rectangle.
  void interpolate(const FloatPixels& pixels, std::span<const PlanePoint> places, LinearTexel* out) const;
  /// Whether every place lies in a rectangle, its sides belonging to it.
  bool all_within(std::span<const PlanePoint> places, const PlanePoint& low, const PlanePoint& high) const;
  /// out[t] = the mean of texels 2t and 2t+1 of two rows, halves rounded up.
  void halve(const LinearTexel* north, const LinearTexel* south, std::size_t width, LinearTexel* out) const;
  /// A sum of pixels, clamped and rounded as the others do.
  LinearTexel quantise(FloatTexel sum) const;

 private:
  static const TexelKernels& kernels_for(KernelIsa isa);
  const TexelKernels& kernels_;
};

const TexelLoops& texel_loops();  ///< for the CPU at hand

}  // namespace cairn
