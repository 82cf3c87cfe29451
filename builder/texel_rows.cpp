#include "builder/texel_rows.h"

#include <emmintrin.h>

#define CAIRN_INLINE [[gnu::always_inline]] inline

namespace cairn {
namespace {

using TexelPair = float __attribute__((vector_size(32)));
using StoredPair = float __attribute__((vector_size(32), aligned(16), may_alias));  // two texels in memory

constexpr float kOne = 65535;

// Through memory, since GCC 12 takes a returned LinearTexel apart.
CAIRN_INLINE void quantise(WideTexel sum, LinearTexel* out) {
  const __m128 most = _mm_set1_ps(kOne), none = _mm_setzero_ps();
  const __m128 alpha = _mm_min_ps(_mm_max_ps(_mm_shuffle_ps(sum, sum, 0xFF), none), most);
  const __m128 clamped = _mm_min_ps(_mm_max_ps(sum, none), alpha);
  const __m128i whole = _mm_cvttps_epi32(_mm_add_ps(clamped, _mm_set1_ps(0.5F)));
  // SSE2 packs signed numbers only.
  const __m128i centred = _mm_sub_epi32(whole, _mm_set1_epi32(32768));
  const __m128i packed = _mm_xor_si128(_mm_packs_epi32(centred, centred), _mm_set1_epi16(-32768));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(out), packed);
}

template <int kCount>
CAIRN_INLINE void filter_by(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps,
                            WideTexel* out) {
  const int count = kCount > 0 ? kCount : taps.count;
  const float* weight = taps.weights.data();
  for (const std::int64_t first : taps.first) {
    const WideTexel* from = pixels + (first - column);
    WideTexel sum{};
    for (int i = 0; i < count; ++i) sum += from[i] * weight[i];
    weight += count;
    *out++ = sum;
  }
}

CAIRN_INLINE void filter_row(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps,
                             WideTexel* out) {
  if (taps.count == 4) return filter_by<4>(pixels, column, taps, out);
  filter_by<0>(pixels, column, taps, out);
}

CAIRN_INLINE void combine_rows(std::span<const WideTexel* const> rows, const float* weights,
                               std::size_t width, LinearTexel* out) {
  constexpr std::size_t kPairs = 4;
  std::size_t t = 0;
  for (; t + 2 * kPairs <= width; t += 2 * kPairs) {
    TexelPair sums[kPairs] = {};
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto* from = reinterpret_cast<const StoredPair*>(rows[i] + t);
      for (std::size_t k = 0; k < kPairs; ++k) sums[k] += from[k] * weights[i];
    }
    for (std::size_t k = 0; k < kPairs; ++k) {
      quantise(__builtin_shufflevector(sums[k], sums[k], 0, 1, 2, 3), out + t + 2 * k);
      quantise(__builtin_shufflevector(sums[k], sums[k], 4, 5, 6, 7), out + t + 2 * k + 1);
    }
  }
  for (; t < width; ++t) {
    WideTexel sum{};
    for (std::size_t i = 0; i < rows.size(); ++i) sum += rows[i][t] * weights[i];
    quantise(sum, out + t);
  }
}

// The four weights of the cubic with a = -1/2 at a fraction between the second and the third pixel.
CAIRN_INLINE WideTexel cubic_weights(float t) {
  constexpr WideTexel a = {-0.5F, 1.5F, -1.5F, 0.5F}, b = {1, -2.5F, 2, -0.5F}, c = {-0.5F, 0, 0.5F, 0},
                      d = {0, 1, 0, 0};
  return ((a * t + b) * t + c) * t + d;
}

CAIRN_INLINE void interpolate_row(const WidePixels& image, std::span<const PlanePoint> places,
                                  LinearTexel* out) {
  for (const PlanePoint& place : places) {
    const std::int64_t x = static_cast<std::int64_t>(place.x + 2) - 2;  // the floor
    const std::int64_t y = static_cast<std::int64_t>(place.y + 2) - 2;
    const WideTexel across = cubic_weights(static_cast<float>(place.x - static_cast<double>(x)));
    const WideTexel down = cubic_weights(static_cast<float>(place.y - static_cast<double>(y)));
    const TexelPair west = __builtin_shufflevector(across, across, 0, 0, 0, 0, 1, 1, 1, 1);
    const TexelPair east = __builtin_shufflevector(across, across, 2, 2, 2, 2, 3, 3, 3, 3);
    const WideTexel* corner = image.pixels + (y - 1 - image.row) * image.columns + (x - 1 - image.column);
    TexelPair sum{};
    for (int r = 0; r < 4; ++r, corner += image.columns) {
      const auto* pixels = reinterpret_cast<const StoredPair*>(corner);
      sum += (pixels[0] * west + pixels[1] * east) * down[r];
    }
    const WideTexel low = __builtin_shufflevector(sum, sum, 0, 1, 2, 3);
    const WideTexel high = __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
    quantise(low + high, out++);
  }
}

CAIRN_INLINE void halve_rows(const LinearTexel* north, const LinearTexel* south, std::size_t width,
                             LinearTexel* out) {
  const __m128i zero = _mm_setzero_si128();
  for (std::size_t t = 0; t < width; ++t) {
    const __m128i n = _mm_loadu_si128(reinterpret_cast<const __m128i*>(north + 2 * t));
    const __m128i s = _mm_loadu_si128(reinterpret_cast<const __m128i*>(south + 2 * t));
    const __m128i sum =
        _mm_add_epi32(_mm_add_epi32(_mm_unpacklo_epi16(n, zero), _mm_unpackhi_epi16(n, zero)),
                      _mm_add_epi32(_mm_unpacklo_epi16(s, zero), _mm_unpackhi_epi16(s, zero)));
    const __m128i mean = _mm_srli_epi32(_mm_add_epi32(sum, _mm_set1_epi32(2)), 2);
    const __m128i centred = _mm_sub_epi32(mean, _mm_set1_epi32(32768));
    const __m128i packed = _mm_xor_si128(_mm_packs_epi32(centred, centred), _mm_set1_epi16(-32768));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + t), packed);
  }
}

[[gnu::target("avx2")]] void filter_avx2(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps,
                                         WideTexel* out) {
  filter_row(pixels, column, taps, out);
}
[[gnu::target("avx2")]] void combine_avx2(std::span<const WideTexel* const> rows, const float* weights,
                                          std::size_t width, LinearTexel* out) {
  combine_rows(rows, weights, width, out);
}
[[gnu::target("avx2")]] void interpolate_avx2(const WidePixels& pixels, std::span<const PlanePoint> places,
                                              LinearTexel* out) {
  interpolate_row(pixels, places, out);
}
[[gnu::target("avx2")]] void halve_avx2(const LinearTexel* north, const LinearTexel* south, std::size_t width,
                                        LinearTexel* out) {
  halve_rows(north, south, width, out);
}

void filter_portable(const WideTexel* pixels, std::int64_t column, const PixelTaps& taps, WideTexel* out) {
  filter_row(pixels, column, taps, out);
}
void combine_portable(std::span<const WideTexel* const> rows, const float* weights, std::size_t width,
                      LinearTexel* out) {
  combine_rows(rows, weights, width, out);
}
void interpolate_portable(const WidePixels& pixels, std::span<const PlanePoint> places, LinearTexel* out) {
  interpolate_row(pixels, places, out);
}
void halve_portable(const LinearTexel* north, const LinearTexel* south, std::size_t width, LinearTexel* out) {
  halve_rows(north, south, width, out);
}

constexpr TexelRows kPortable = {filter_portable, combine_portable, interpolate_portable, halve_portable};
constexpr TexelRows kAvx2 = {filter_avx2, combine_avx2, interpolate_avx2, halve_avx2};

}  // namespace

const TexelRows& texel_rows(KernelIsa isa) {
  return isa == KernelIsa::avx2 ? kAvx2 : kPortable;
}

const TexelRows& texel_rows() {
  return texel_rows(widest_kernel_isa());
}

LinearTexel to_linear_texel(WideTexel sum) {
  LinearTexel texel;
  quantise(sum, &texel);
  return texel;
}

}  // namespace cairn
