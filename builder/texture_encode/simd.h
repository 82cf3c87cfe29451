#pragma once

// Vectors of 32-bit lanes, one block a lane. Every kernel file is compiled once for each instruction set, in
// the namespace CAIRN_ISA, so that no inline function of one set can be linked into another. All operations
// act on each lane alone and round as IEEE 754 says, so a block's code does not depend on the number of
// lanes.
//
// Kernel files must not include headers with inline functions that the other instruction set's files, or the
// rest of the program, also use: the linker keeps one copy of those.

#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace cairn::CAIRN_ISA {

#if defined(__AVX512F__)
inline constexpr int kLanes = 16;
#elif defined(__AVX2__)
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

using I = std::int32_t __attribute__((vector_size(4 * kLanes)));
using F = float __attribute__((vector_size(4 * kLanes)));

#define CAIRN_INLINE [[gnu::always_inline]] inline

CAIRN_INLINE I splat(std::int32_t value) {
  return I{} + value;
}
CAIRN_INLINE F splat(float value) {
  return F{} + value;
}

/// Toward zero. REQUIRES: |value| < 2^31 in every lane.
CAIRN_INLINE I truncate(F value) {
  return __builtin_convertvector(value, I);
}
CAIRN_INLINE F to_float(I value) {
  return __builtin_convertvector(value, F);
}

/// To the nearest whole number, halves to even. REQUIRES: 0 <= value < 2^22 in every lane.
CAIRN_INLINE F round(F value) {
  return (value + 8388608.0F) - 8388608.0F;
}

/// a where the mask is all ones, b where it is all zeros.
CAIRN_INLINE I select(I mask, I a, I b) {
#if defined(__AVX512F__)
  return mask ? a : b;  // the compiler turns a comparison to a mask register at once
#else
  return (mask & a) | (~mask & b);
#endif
}
CAIRN_INLINE F select(I mask, F a, F b) {
#if defined(__AVX512F__)
  return mask ? a : b;
#elif defined(__AVX2__)
  return _mm256_blendv_ps(b, a, reinterpret_cast<F>(mask));
#else
  return reinterpret_cast<F>(select(mask, reinterpret_cast<I>(a), reinterpret_cast<I>(b)));
#endif
}

/// b where either is NaN.
CAIRN_INLINE F min(F a, F b) {
#if defined(__AVX512F__)
  return _mm512_min_ps(a, b);
#elif defined(__AVX2__)
  return _mm256_min_ps(a, b);
#elif defined(__SSE2__)
  return _mm_min_ps(a, b);
#else
  return select(a < b, a, b);
#endif
}
CAIRN_INLINE F max(F a, F b) {
#if defined(__AVX512F__)
  return _mm512_max_ps(a, b);
#elif defined(__AVX2__)
  return _mm256_max_ps(a, b);
#elif defined(__SSE2__)
  return _mm_max_ps(a, b);
#else
  return select(a > b, a, b);
#endif
}
CAIRN_INLINE I min(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(_mm512_min_epi32(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return reinterpret_cast<I>(_mm256_min_epi32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
#else
  return select(a < b, a, b);
#endif
}
CAIRN_INLINE I max(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(_mm512_max_epi32(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return reinterpret_cast<I>(_mm256_max_epi32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
#else
  return select(a > b, a, b);
#endif
}

CAIRN_INLINE F clamp(F value, float low, float high) {
  return min(max(value, splat(low)), splat(high));
}

/// table[index] in every lane.
CAIRN_INLINE I lookup(const std::int32_t* table, I index) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(_mm512_i32gather_epi32(reinterpret_cast<__m512i>(index), table, 4));
#elif defined(__AVX2__)
  return reinterpret_cast<I>(_mm256_i32gather_epi32(table, reinterpret_cast<__m256i>(index), 4));
#else
  I found{};
  for (int lane = 0; lane < kLanes; ++lane) found[lane] = table[index[lane]];
  return found;
#endif
}

/// values[index], lane by lane.
CAIRN_INLINE F pick(const F* values, I index) {
#if defined(__AVX512F__)
  const I lanes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const I place = index * kLanes + lanes;
  return _mm512_i32gather_ps(reinterpret_cast<__m512i>(place), reinterpret_cast<const float*>(values), 4);
#elif defined(__AVX2__)
  const I lanes = {0, 1, 2, 3, 4, 5, 6, 7};
  const I place = index * kLanes + lanes;
  return _mm256_i32gather_ps(reinterpret_cast<const float*>(values), reinterpret_cast<__m256i>(place), 4);
#else
  F found{};
  for (int lane = 0; lane < kLanes; ++lane) found[lane] = values[index[lane]][lane];
  return found;
#endif
}

/// A number of 0..31 hidden in the lowest bits of a float >= 0: a change of at most 2^-18 of it.
CAIRN_INLINE F tagged(F value, int tag) {
  return reinterpret_cast<F>((reinterpret_cast<I>(value) & ~31) | tag);
}
CAIRN_INLINE I tag_of(F value) {
  return reinterpret_cast<I>(value) & 31;
}

/// One texel of each of kLanes blocks, as they lie in memory: R lowest, A highest.
CAIRN_INLINE I red(I texel) {
  return texel & 255;
}
CAIRN_INLINE I green(I texel) {
  return texel >> 8 & 255;
}
CAIRN_INLINE I blue(I texel) {
  return texel >> 16 & 255;
}
CAIRN_INLINE I alpha(I texel) {
  return texel >> 24 & 255;
}

/// The block, counted from the left, that lane `lane` of load_texels() holds: 128 bits of a row are a block,
/// and those that lie above one another in four vectors are turned.
CAIRN_INLINE int block_of_lane(int lane) {
  constexpr int kQuarters = kLanes / 4;
  return lane % 4 * kQuarters + lane / 4;
}

/// a0 b0 a1 b1 of each 128 bits of two vectors, and a2 b2 a3 b3; then the same with pairs.
CAIRN_INLINE I zip_low(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(
      _mm512_unpacklo_epi32(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
#else
  return __builtin_shufflevector(a, b, 0, 4, 1, 5);
#endif
}
CAIRN_INLINE I zip_high(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(
      _mm512_unpackhi_epi32(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
#else
  return __builtin_shufflevector(a, b, 2, 6, 3, 7);
#endif
}
CAIRN_INLINE I zip_pairs_low(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(
      _mm512_unpacklo_epi64(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
#else
  return __builtin_shufflevector(a, b, 0, 1, 4, 5);
#endif
}
CAIRN_INLINE I zip_pairs_high(I a, I b) {
#if defined(__AVX512F__)
  return reinterpret_cast<I>(
      _mm512_unpackhi_epi64(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
#else
  return __builtin_shufflevector(a, b, 2, 3, 6, 7);
#endif
}

/// Turns one row of kLanes blocks (16·kLanes bytes) to four vectors, one for each column of the blocks.
CAIRN_INLINE void load_columns(const std::uint8_t* row, I columns[4]) {
  I a, b, c, d;
  std::memcpy(&a, row, sizeof(I));
  std::memcpy(&b, row + sizeof(I), sizeof(I));
  std::memcpy(&c, row + 2 * sizeof(I), sizeof(I));
  std::memcpy(&d, row + 3 * sizeof(I), sizeof(I));
  const I ab_low = zip_low(a, b), ab_high = zip_high(a, b), cd_low = zip_low(c, d), cd_high = zip_high(c, d);
  columns[0] = zip_pairs_low(ab_low, cd_low);
  columns[1] = zip_pairs_high(ab_low, cd_low);
  columns[2] = zip_pairs_low(ab_high, cd_high);
  columns[3] = zip_pairs_high(ab_high, cd_high);
}

/// The texels of kLanes blocks side by side, in rows `stride` bytes apart.
CAIRN_INLINE void load_texels(const std::uint8_t* first_row, std::ptrdiff_t stride, I texels[16]) {
  for (int y = 0; y < 4; ++y) load_columns(first_row + y * stride, texels + 4 * y);
}

}  // namespace cairn::CAIRN_ISA
