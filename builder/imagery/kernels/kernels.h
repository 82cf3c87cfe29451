#pragma once

// The inner loops of resampling: compiled once for every instruction set, with the same bits in all of them.

#include <cstddef>
#include <cstdint>

namespace cairn {

/// One texel in linear light: R, G, B times alpha, and alpha, 0…65535.
using FloatTexel = float __attribute__((vector_size(16)));

/// A rectangle of pixels in linear light.
struct FloatPixels {
  const FloatTexel* pixels = nullptr;  ///< the one at (column, row), rows from the north
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 0;
};

/// TexelLoops (builder/imagery/texel_loops.h), in plain pointers. Where `out` is whole numbers, and what
/// halve reads, are LinearTexels: four numbers each. `places` are x, y of each texel.
struct TexelKernels {
  void (*filter)(const FloatTexel* pixels, std::int64_t column, const std::int64_t* first,
                 const float* weights, int count, std::size_t width, FloatTexel* out);
  void (*combine)(const FloatTexel* const* rows, const float* weights, std::size_t count, std::size_t width,
                  std::uint16_t* out);
  void (*interpolate)(const FloatPixels& image, const double* places, std::size_t width, std::uint16_t* out);
  bool (*all_within)(const double* places, std::size_t count, const double* low, const double* high);
  void (*halve)(const std::uint16_t* north, const std::uint16_t* south, std::size_t width,
                std::uint16_t* out);
  void (*quantise)(const FloatTexel& sum, std::uint16_t* out);
};

namespace portable {
extern const TexelKernels texel_kernels;
}
namespace avx2 {
extern const TexelKernels texel_kernels;
}
namespace avx512 {
extern const TexelKernels texel_kernels;
}

}  // namespace cairn
