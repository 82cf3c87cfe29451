#pragma once

// Four texels side by side. Compiled once for each instruction set, in the namespace CAIRN_ISA; as the
// texture kernels' simd.h says, with no inline function that another set's files could share. Every operation
// acts on each number alone and rounds as IEEE 754 says, and sums are taken in one order, so all sets give
// the same bits.

#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "builder/imagery/kernels/kernels.h"

#define CAIRN_INLINE [[gnu::always_inline]] inline

namespace cairn::CAIRN_ISA {

#if defined(__AVX512F__)
inline constexpr int kParts = 1;
#elif defined(__AVX2__)
inline constexpr int kParts = 2;
#else
inline constexpr int kParts = 4;
#endif

using Part = float __attribute__((vector_size(64 / kParts)));

struct Quad {
  Part part[kParts];
};

CAIRN_INLINE Quad load(const FloatTexel* from) {
  Quad quad;
  std::memcpy(&quad, from, sizeof quad);
  return quad;
}

CAIRN_INLINE void store(const Quad& quad, float* to) {
  std::memcpy(to, &quad, sizeof quad);
}

/// The same four numbers in each texel.
CAIRN_INLINE Quad repeated(FloatTexel numbers) {
  const FloatTexel four[4] = {numbers, numbers, numbers, numbers};
  return load(four);
}

CAIRN_INLINE Quad operator*(Quad a, float b) {
  for (Part& part : a.part) part *= b;
  return a;
}
CAIRN_INLINE Quad operator*(Quad a, const Quad& b) {
  for (int i = 0; i < kParts; ++i) a.part[i] *= b.part[i];
  return a;
}
CAIRN_INLINE Quad operator+(Quad a, const Quad& b) {
  for (int i = 0; i < kParts; ++i) a.part[i] += b.part[i];
  return a;
}

/// Weight i in all numbers of texel i.
CAIRN_INLINE Quad spread(FloatTexel weights) {
  Quad quad;
#if defined(__AVX512F__)
  const __m512i each = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
  quad.part[0] = _mm512_permutexvar_ps(each, _mm512_castps128_ps512(weights));
#elif defined(__AVX2__)
  const __m256 all = _mm256_castps128_ps256(weights);
  quad.part[0] = _mm256_permutevar8x32_ps(all, _mm256_set_epi32(1, 1, 1, 1, 0, 0, 0, 0));
  quad.part[1] = _mm256_permutevar8x32_ps(all, _mm256_set_epi32(3, 3, 3, 3, 2, 2, 2, 2));
#else
  for (int i = 0; i < 4; ++i) quad.part[i] = FloatTexel{} + weights[i];
#endif
  return quad;
}

/// (0 + 2) + (1 + 3).
CAIRN_INLINE FloatTexel sum_of(const Quad& quad) {
#if defined(__AVX512F__)
  const __m256 pair = _mm512_castps512_ps256(quad.part[0]) + _mm512_extractf32x8_ps(quad.part[0], 1);
  return _mm256_castps256_ps128(pair) + _mm256_extractf128_ps(pair, 1);
#elif defined(__AVX2__)
  const __m256 pair = quad.part[0] + quad.part[1];
  return _mm256_castps256_ps128(pair) + _mm256_extractf128_ps(pair, 1);
#else
  return (quad.part[0] + quad.part[2]) + (quad.part[1] + quad.part[3]);
#endif
}

/// sum_of() each of four, side by side. In registers: memory written in pieces and read back as a whole makes
/// the processor wait.
CAIRN_INLINE Quad sums_of(const Quad& a, const Quad& b, const Quad& c, const Quad& d) {
  Quad sums;
#if defined(__AVX512F__)
  const __m512 ab = _mm512_shuffle_f32x4(a.part[0], b.part[0], 0x44) +  // 0 and 1 of each, 2 and 3 of each
                    _mm512_shuffle_f32x4(a.part[0], b.part[0], 0xEE);
  const __m512 cd =
      _mm512_shuffle_f32x4(c.part[0], d.part[0], 0x44) + _mm512_shuffle_f32x4(c.part[0], d.part[0], 0xEE);
  sums.part[0] = _mm512_shuffle_f32x4(ab, cd, 0x88) + _mm512_shuffle_f32x4(ab, cd, 0xDD);
#elif defined(__AVX2__)
  const __m256 pairs[4] = {a.part[0] + a.part[1], b.part[0] + b.part[1], c.part[0] + c.part[1],
                           d.part[0] + d.part[1]};
  for (int i = 0; i < 2; ++i)
    sums.part[i] = _mm256_permute2f128_ps(pairs[2 * i], pairs[2 * i + 1], 0x20) +
                   _mm256_permute2f128_ps(pairs[2 * i], pairs[2 * i + 1], 0x31);
#else
  sums.part[0] = sum_of(a);
  sums.part[1] = sum_of(b);
  sums.part[2] = sum_of(c);
  sums.part[3] = sum_of(d);
#endif
  return sums;
}

/// Clamps alpha to 0…65535, colours to 0…alpha, and rounds.
CAIRN_INLINE void quantise(const Quad& sums, std::uint16_t* out) {
#if defined(__AVX512F__)
  const __m512 none = _mm512_setzero_ps(), most = _mm512_set1_ps(65535.0F), half = _mm512_set1_ps(0.5F);
  const __m512 sum = sums.part[0];
  const __m512 alpha = _mm512_min_ps(_mm512_max_ps(_mm512_shuffle_ps(sum, sum, 0xFF), none), most);
  const __m512 clamped = _mm512_min_ps(_mm512_max_ps(sum, none), alpha);
  const __m256i packed = _mm512_cvtepi32_epi16(_mm512_cvttps_epi32(_mm512_add_ps(clamped, half)));
  std::memcpy(out, &packed, sizeof packed);
#elif defined(__AVX2__)
  const __m256 none = _mm256_setzero_ps(), most = _mm256_set1_ps(65535.0F), half = _mm256_set1_ps(0.5F);
  __m256i whole[2];
  for (int i = 0; i < 2; ++i) {
    const __m256 sum = sums.part[i];
    const __m256 alpha = _mm256_min_ps(_mm256_max_ps(_mm256_shuffle_ps(sum, sum, 0xFF), none), most);
    const __m256 clamped = _mm256_min_ps(_mm256_max_ps(sum, none), alpha);
    whole[i] = _mm256_cvttps_epi32(_mm256_add_ps(clamped, half));
  }
  const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(whole[0], whole[1]), 0xD8);
  std::memcpy(out, &packed, sizeof packed);
#else
  for (int i = 0; i < 4; ++i) {
    const FloatTexel none{}, sum = sums.part[i];
    const FloatTexel above = sum > none ? sum : none;
    const FloatTexel alpha = none + (above[3] < 65535.0F ? above[3] : 65535.0F);
    const FloatTexel clamped = above < alpha ? above : alpha;
    for (int k = 0; k < 4; ++k) out[4 * i + k] = static_cast<std::uint16_t>(clamped[k] + 0.5F);
  }
#endif
}

/// The same for the first `count` <= 4 of four texels.
CAIRN_INLINE void quantise(const FloatTexel sums[4], std::size_t count, std::uint16_t* out) {
  std::uint16_t whole[16];
  quantise(load(sums), whole);
  std::memcpy(out, whole, count * 8);
}

}  // namespace cairn::CAIRN_ISA
