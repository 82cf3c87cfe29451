#include "builder/imagery/texel_rows.h"

namespace cairn {

const TexelKernels& TexelRows::kernels_for(KernelIsa isa) {
  switch (isa) {
    case KernelIsa::avx512:
      return avx512::texel_kernels;
    case KernelIsa::avx2:
      return avx2::texel_kernels;
    case KernelIsa::portable:
      break;
  }
  return portable::texel_kernels;
}

void TexelRows::filter(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps,
                       WideTexel* out) const {
  kernels_.filter(pixels, column, taps.first.data(), taps.weights.data(), taps.count, taps.first.size(), out);
}

void TexelRows::combine(std::span<const WideTexel* const> rows, const float* weights, std::size_t width,
                        LinearTexel* out) const {
  kernels_.combine(rows.data(), weights, rows.size(), width, out->data());
}

void TexelRows::interpolate(const WidePixels& image, std::span<const PlanePoint> places,
                            LinearTexel* out) const {
  static_assert(sizeof(PlanePoint) == 2 * sizeof(double));
  if (places.empty()) return;
  kernels_.interpolate(image, &places.front().x, places.size(), out->data());
}

bool TexelRows::all_within(std::span<const PlanePoint> places, const PlanePoint& low,
                           const PlanePoint& high) const {
  return places.empty() || kernels_.all_within(&places.front().x, places.size(), &low.x, &high.x);
}

void TexelRows::halve(const LinearTexel* north, const LinearTexel* south, std::size_t width,
                      LinearTexel* out) const {
  kernels_.halve(north->data(), south->data(), width, out->data());
}

LinearTexel TexelRows::quantise(WideTexel sum) const {
  LinearTexel texel;
  kernels_.quantise(sum, texel.data());
  return texel;
}

const TexelRows& texel_rows() {
  static const TexelRows widest(widest_kernel_isa());
  return widest;
}

}  // namespace cairn
