#include "builder/imagery/kernels/quad.h"

namespace cairn::CAIRN_ISA {
namespace {

CAIRN_INLINE FloatTexel filter_one(const FloatTexel* pixels, const float* weights, int count) {
  FloatTexel sum{};
  for (int i = 0; i < count; ++i) sum += pixels[i] * weights[i];
  return sum;
}

void filter(const FloatTexel* pixels, std::int64_t column, const std::int64_t* first, const float* weights,
            int count, std::size_t width, FloatTexel* out) {
  if (count != 4) {
    for (std::size_t t = 0; t < width; ++t, weights += count)
      out[t] = filter_one(pixels + (first[t] - column), weights, count);
    return;
  }
  for (std::size_t t = 0; t < width; ++t, weights += 4) {
    FloatTexel four;
    std::memcpy(&four, weights, sizeof four);
    out[t] = sum_of(load(pixels + (first[t] - column)) * spread(four));
  }
}

// kQuads·4 texels from texel t on.
template <int kQuads>
CAIRN_INLINE void combine_quads(const FloatTexel* const* rows, const float* weights, std::size_t count,
                                std::size_t t, std::uint16_t* out) {
  Quad sums[kQuads] = {};
  for (std::size_t i = 0; i < count; ++i) {
    for (int k = 0; k < kQuads; ++k) sums[k] = sums[k] + load(rows[i] + t + 4 * k) * weights[i];
  }
  for (int k = 0; k < kQuads; ++k) quantise(sums[k], out + 4 * t + 16 * k);
}

void combine(const FloatTexel* const* rows, const float* weights, std::size_t count, std::size_t width,
             std::uint16_t* out) {
  constexpr int kQuads = kParts == 1 ? 8 : 2;
  std::size_t t = 0;
  for (; t + 4 * kQuads <= width; t += 4 * kQuads) combine_quads<kQuads>(rows, weights, count, t, out);
  for (; t + 4 <= width; t += 4) combine_quads<1>(rows, weights, count, t, out);
  if (t == width) return;
  FloatTexel rest[4] = {};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < width - t; ++k) rest[k] += rows[i][t + k] * weights[i];
  }
  quantise(rest, width - t, out + 4 * t);
}

// Where texels lie between pixels: the cell of each coordinate, and the cubic's weights (a = -1/2) at the
// place in it, four across and four down. Worked out for many texels at once, since one has little for wide
// registers to do.
struct CubicPlaces {
  static constexpr std::size_t kMost = 64;  // a multiple of 4
  std::int32_t cell[2 * kMost];
  float weight[8 * kMost];
};

// REQUIRES: count <= kMost.
CAIRN_INLINE void find_places(const double* places, std::size_t count, CubicPlaces& found) {
  float fraction[2 * CubicPlaces::kMost] = {};
  for (std::size_t i = 0; i < 2 * count; ++i) {
    const double beyond = places[i] + 2;  // above 0, so cut off is the floor
    const auto whole = static_cast<std::int32_t>(beyond);
    found.cell[i] = whole - 3;  // the first of four pixels
    fraction[i] = static_cast<float>(beyond - whole);
  }
  const Quad a = repeated(FloatTexel{-0.5F, 1.5F, -1.5F, 0.5F}), b = repeated(FloatTexel{1, -2.5F, 2, -0.5F});
  const Quad c = repeated(FloatTexel{-0.5F, 0, 0.5F, 0}), d = repeated(FloatTexel{0, 1, 0, 0});
  for (std::size_t i = 0; i < 2 * count; i += 4) {
    FloatTexel two;  // texels' x and y
    std::memcpy(&two, fraction + i, sizeof two);
    const Quad t = spread(two);
    store(((a * t + b) * t + c) * t + d, found.weight + 4 * i);
  }
}

// Texel t of those places, not summed across: down the four columns first.
CAIRN_INLINE Quad interpolate_one(const FloatPixels& image, const CubicPlaces& places, std::size_t t) {
  const float* weight = places.weight + 8 * t;
  const FloatTexel* corner = image.pixels + (places.cell[2 * t + 1] - image.row) * image.columns +
                             (places.cell[2 * t] - image.column);
  Quad sum = load(corner) * weight[4];
  for (int r = 1; r < 4; ++r) sum = sum + load(corner + r * image.columns) * weight[4 + r];
  FloatTexel across;
  std::memcpy(&across, weight, sizeof across);
  return sum * spread(across);
}

// REQUIRES: count <= kMost.
CAIRN_INLINE void interpolate_some(const FloatPixels& image, const double* places, std::size_t count,
                                   std::uint16_t* out) {
  CubicPlaces found;
  find_places(places, count, found);
  std::size_t t = 0;
  for (; t + 4 <= count; t += 4)
    quantise(sums_of(interpolate_one(image, found, t), interpolate_one(image, found, t + 1),
                     interpolate_one(image, found, t + 2), interpolate_one(image, found, t + 3)),
             out + 4 * t);
  if (t == count) return;
  FloatTexel rest[4] = {};
  for (std::size_t k = 0; k < count - t; ++k) rest[k] = sum_of(interpolate_one(image, found, t + k));
  quantise(rest, count - t, out + 4 * t);
}

void interpolate(const FloatPixels& image, const double* places, std::size_t width, std::uint16_t* out) {
  for (std::size_t t = 0; t < width; t += CubicPlaces::kMost) {
    const std::size_t count = width - t < CubicPlaces::kMost ? width - t : CubicPlaces::kMost;
    interpolate_some(image, places + 2 * t, count, out + 4 * t);
  }
}

#if defined(__AVX512F__)
// Four places at a time; the last four may be looked at twice. REQUIRES: count >= 4.
bool all_within_fours(const double* places, std::size_t count, const double* low, const double* high) {
  const __m512d least = _mm512_broadcast_f64x2(_mm_loadu_pd(low)),
                most = _mm512_broadcast_f64x2(_mm_loadu_pd(high));
  __mmask8 above = 0xFF, below = 0xFF;
  const auto look_at = [&](std::size_t i) __attribute__((always_inline)) {
    const __m512d four = _mm512_loadu_pd(places + 2 * i);
    above = _kand_mask8(above, _mm512_cmp_pd_mask(four, least, _CMP_GE_OQ));
    below = _kand_mask8(below, _mm512_cmp_pd_mask(four, most, _CMP_LE_OQ));
  };
  for (std::size_t i = 0; i + 4 <= count; i += 4) look_at(i);
  look_at(count - 4);
  return (above & below) == 0xFF;
}
#elif defined(__AVX2__)
bool all_within_fours(const double* places, std::size_t count, const double* low, const double* high) {
  const __m256d least = _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(low)),
                most = _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(high));
  __m256d within = _mm256_cmp_pd(least, least, _CMP_EQ_OQ);
  const auto look_at = [&](std::size_t i) __attribute__((always_inline)) {
    const __m256d two = _mm256_loadu_pd(places + 2 * i);
    within = _mm256_and_pd(
        within, _mm256_and_pd(_mm256_cmp_pd(two, least, _CMP_GE_OQ), _mm256_cmp_pd(two, most, _CMP_LE_OQ)));
  };
  for (std::size_t i = 0; i + 2 <= count; i += 2) look_at(i);
  look_at(count - 2);
  return _mm256_movemask_pd(within) == 15;
}
#endif

bool all_within(const double* places, std::size_t count, const double* low, const double* high) {
#if defined(__AVX2__)
  if (count >= 4) return all_within_fours(places, count, low, high);
#endif
  bool within = true;
  for (std::size_t i = 0; i < 2 * count; ++i) within &= places[i] >= low[i % 2] && places[i] <= high[i % 2];
  return within;
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
  for (int t = 0; t < 4; ++t) halve_one(north + 8 * t, south + 8 * t, out + 4 * t);
}
#endif

void halve(const std::uint16_t* north, const std::uint16_t* south, std::size_t width, std::uint16_t* out) {
  std::size_t t = 0;
  for (; t + 4 <= width; t += 4) halve_four(north + 8 * t, south + 8 * t, out + 4 * t);
  for (; t < width; ++t) halve_one(north + 8 * t, south + 8 * t, out + 4 * t);
}

void quantise_one(const FloatTexel& sum, std::uint16_t* out) {
  const FloatTexel four[4] = {sum};
  quantise(four, 1, out);
}

}  // namespace

const TexelKernels texel_kernels = {filter, combine, interpolate, all_within, halve, quantise_one};

}  // namespace cairn::CAIRN_ISA
