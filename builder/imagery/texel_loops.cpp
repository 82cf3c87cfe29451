#include "builder/imagery/texel_loops.h"

namespace cairn {

const TexelKernels& TexelLoops::kernels_for(KernelIsa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case KernelIsa::avx512:
      return avx512::texel_kernels;
    case KernelIsa::avx2:
      return avx2::texel_kernels;
#endif
    default:
      return portable::texel_kernels;
  }
}

void TexelLoops::filter(const FloatTexel* pixels, std::int64_t column, const PixelTaps& taps,
                        FloatTexel* out) const {
  kernels_.filter(pixels, column, taps.first.data(), taps.weights.data(), taps.count, taps.first.size(), out);
}

void TexelLoops::combine(std::span<const FloatTexel* const> rows, const float* weights, std::size_t width,
                         LinearTexel* out) const {
  kernels_.combine(rows.data(), weights, rows.size(), width, out->data());
}

void TexelLoops::interpolate(const FloatPixels& image, std::span<const PlanePoint> places,
                             LinearTexel* out) const {
  static_assert(sizeof(PlanePoint) == 2 * sizeof(double));
  if (places.empty()) return;
  kernels_.interpolate(image, &places.front().x, places.size(), out->data());
}

bool TexelLoops::all_within(std::span<const PlanePoint> places, const PlanePoint& low,
                            const PlanePoint& high) const {
  return places.empty() || kernels_.all_within(&places.front().x, places.size(), &low.x, &high.x);
}

void TexelLoops::halve(const LinearTexel* north, const LinearTexel* south, std::size_t width,
                       LinearTexel* out) const {
  kernels_.halve(north->data(), south->data(), width, out->data());
}

LinearTexel TexelLoops::quantise(FloatTexel sum) const {
  LinearTexel texel;
  kernels_.quantise(sum, texel.data());
  return texel;
}

const TexelLoops& texel_loops() {
  static const TexelLoops widest(widest_kernel_isa());
  return widest;
}

}  // namespace cairn
