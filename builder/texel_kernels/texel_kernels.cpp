#include "builder/texel_kernels/quad.h"

namespace cairn::CAIRN_ISA {
namespace {

CAIRN_INLINE WideTexel filter_one(const WideTexel* pixels, const float* weights, int count) {
  WideTexel sum{};
  for (int i = 0; i < count; ++i) sum += pixels[i] * weights[i];
  return sum;
}

void filter(const WideTexel* pixels, std::int64_t column, const std::int64_t* first, const float* weights,
            int count, std::size_t width, WideTexel* out) {
  if (count != 4) {
    for (std::size_t t = 0; t < width; ++t, weights += count)
      out[t] = filter_one(pixels + (first[t] - column), weights, count);
    return;
  }
  for (std::size_t t = 0; t < width; ++t, weights += 4) {
    WideTexel four;
    std::memcpy(&four, weights, sizeof four);
    out[t] = sum_of(load(pixels + (first[t] - column)) * spread(four));
  }
}

// kQuads·4 texels from texel t on.
template <int kQuads>
CAIRN_INLINE void combine_quads(const WideTexel* const* rows, const float* weights, std::size_t count,
                                std::size_t t, std::uint16_t* out) {
  Quad sums[kQuads] = {};
  for (std::size_t i = 0; i < count; ++i) {
    for (int k = 0; k < kQuads; ++k) sums[k] = sums[k] + load(rows[i] + t + 4 * k) * weights[i];
  }
  for (int k = 0; k < kQuads; ++k) quantise(sums[k], out + 4 * t + 16 * k);
}

void combine(const WideTexel* const* rows, const float* weights, std::size_t count, std::size_t width,
             std::uint16_t* out) {
  constexpr int kQuads = kParts == 1 ? 8 : 2;
  std::size_t t = 0;
  for (; t + 4 * kQuads <= width; t += 4 * kQuads) combine_quads<kQuads>(rows, weights, count, t, out);
  for (; t + 4 <= width; t += 4) combine_quads<1>(rows, weights, count, t, out);
  if (t == width) return;
  WideTexel rest[4] = {};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < width - t; ++k) rest[k] += rows[i][t + k] * weights[i];
  }
  quantise(rest, width - t, out + 4 * t);
}

struct CubicWeights {
  WideTexel across, down;
};

// The four weights of the cubic with a = -1/2 at a fraction between the second and the third pixel, on both
// axes.
CAIRN_INLINE CubicWeights cubic_weights(float x, float y) {
  using Both = float __attribute__((vector_size(32)));
  constexpr Both a = {-0.5F, 1.5F, -1.5F, 0.5F, -0.5F, 1.5F, -1.5F, 0.5F};
  constexpr Both b = {1, -2.5F, 2, -0.5F, 1, -2.5F, 2, -0.5F};
  constexpr Both c = {-0.5F, 0, 0.5F, 0, -0.5F, 0, 0.5F, 0};
  constexpr Both d = {0, 1, 0, 0, 0, 1, 0, 0};
  const Both t = {x, x, x, x, y, y, y, y};
  const Both weights = ((a * t + b) * t + c) * t + d;
  return {__builtin_shufflevector(weights, weights, 0, 1, 2, 3),
          __builtin_shufflevector(weights, weights, 4, 5, 6, 7)};
}

// Down the four columns first, then across.
CAIRN_INLINE WideTexel interpolate_one(const WidePixels& image, const double* place) {
  const std::int64_t x = static_cast<std::int64_t>(place[0] + 2) - 2;  // the floor
  const std::int64_t y = static_cast<std::int64_t>(place[1] + 2) - 2;
  const auto [across, down] = cubic_weights(static_cast<float>(place[0] - static_cast<double>(x)),
                                            static_cast<float>(place[1] - static_cast<double>(y)));
  const WideTexel* corner = image.pixels + (y - 1 - image.row) * image.columns + (x - 1 - image.column);
  Quad sum = load(corner) * down[0];
  for (int r = 1; r < 4; ++r) sum = sum + load(corner + r * image.columns) * down[r];
  return sum_of(sum * spread(across));
}

void interpolate(const WidePixels& image, const double* places, std::size_t width, std::uint16_t* out) {
  std::size_t t = 0;
  for (; t + 4 <= width; t += 4, places += 8) {
    const WideTexel a = interpolate_one(image, places), b = interpolate_one(image, places + 2);
    const WideTexel c = interpolate_one(image, places + 4), d = interpolate_one(image, places + 6);
    quantise(quad_of(a, b, c, d), out + 4 * t);
  }
  if (t == width) return;
  WideTexel sums[4] = {};
  for (std::size_t k = 0; k < width - t; ++k) sums[k] = interpolate_one(image, places + 2 * k);
  quantise(sums, width - t, out + 4 * t);
}

bool all_within(const double* places, std::size_t count, const double* low, const double* high) {
  const __m128d least = _mm_loadu_pd(low), most = _mm_loadu_pd(high);
  __m128d within = _mm_cmpeq_pd(least, least);
  for (std::size_t i = 0; i < count; ++i) {
    const __m128d place = _mm_loadu_pd(places + 2 * i);
    within = _mm_and_pd(within, _mm_and_pd(_mm_cmpge_pd(place, least), _mm_cmple_pd(place, most)));
  }
  return _mm_movemask_pd(within) == 3;
}

// One texel from two of each row.
CAIRN_INLINE void halve_one(const std::uint16_t* north, const std::uint16_t* south, std::uint16_t* out) {
  for (int k = 0; k < 4; ++k)
    out[k] = static_cast<std::uint16_t>((north[k] + north[4 + k] + south[k] + south[4 + k] + 2) / 4);
}

#if defined(__AVX2__)
// Four texels from eight of each row. 128 bits hold a pair of texels, whose halves are added.
CAIRN_INLINE void halve_four(const std::uint16_t* north, const std::uint16_t* south, std::uint16_t* out) {
  const __m256i zero = _mm256_setzero_si256(), two = _mm256_set1_epi32(2);
  __m256i mean[2];
  for (int i = 0; i < 2; ++i) {
    const __m256i n = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(north + 16 * i));
    const __m256i s = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(south + 16 * i));
    const __m256i sum =
        _mm256_add_epi32(_mm256_add_epi32(_mm256_unpacklo_epi16(n, zero), _mm256_unpackhi_epi16(n, zero)),
                         _mm256_add_epi32(_mm256_unpacklo_epi16(s, zero), _mm256_unpackhi_epi16(s, zero)));
    mean[i] = _mm256_srli_epi32(_mm256_add_epi32(sum, two), 2);
  }
  const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(mean[0], mean[1]), 0xD8);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), packed);
}
#else
CAIRN_INLINE void halve_four(const std::uint16_t* north, const std::uint16_t* south, std::uint16_t* out) {
  const __m128i zero = _mm_setzero_si128();
  for (int t = 0; t < 4; ++t) {
    const __m128i n = _mm_loadu_si128(reinterpret_cast<const __m128i*>(north + 8 * t));
    const __m128i s = _mm_loadu_si128(reinterpret_cast<const __m128i*>(south + 8 * t));
    const __m128i sum =
        _mm_add_epi32(_mm_add_epi32(_mm_unpacklo_epi16(n, zero), _mm_unpackhi_epi16(n, zero)),
                      _mm_add_epi32(_mm_unpacklo_epi16(s, zero), _mm_unpackhi_epi16(s, zero)));
    const __m128i mean = _mm_srli_epi32(_mm_add_epi32(sum, _mm_set1_epi32(2)), 2);
    const __m128i centred = _mm_sub_epi32(mean, _mm_set1_epi32(32768));
    const __m128i packed = _mm_xor_si128(_mm_packs_epi32(centred, centred), _mm_set1_epi16(-32768));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + 4 * t), packed);
  }
}
#endif

void halve(const std::uint16_t* north, const std::uint16_t* south, std::size_t width, std::uint16_t* out) {
  std::size_t t = 0;
  for (; t + 4 <= width; t += 4) halve_four(north + 8 * t, south + 8 * t, out + 4 * t);
  for (; t < width; ++t) halve_one(north + 8 * t, south + 8 * t, out + 4 * t);
}

void quantise_one(const WideTexel& sum, std::uint16_t* out) {
  const WideTexel four[4] = {sum};
  quantise(four, 1, out);
}

}  // namespace

const TexelKernels texel_kernels = {filter, combine, interpolate, all_within, halve, quantise_one};

}  // namespace cairn::CAIRN_ISA
