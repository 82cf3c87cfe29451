#pragma once

// What decode_avx2.cpp uses of AVX2, on WebAssembly's vectors of 128 bits: a vector of 256 bits is two of
// them. Names and meanings are Intel's (Intrinsics Guide), of those operations only.

#if defined(__wasm_simd128__)

#include <cstdint>
#include <cstring>

#include <wasm_simd128.h>

using __m128i = v128_t;

struct alignas(32) __m256i {
  v128_t low;
  v128_t high;
};

namespace cairn::wavefront {

#define CAIRN_WASM_INLINE inline __attribute__((always_inline))

// --- 128 bits. ---

CAIRN_WASM_INLINE __m128i _mm_load_si128(const __m128i* at) {
  return wasm_v128_load(at);
}
CAIRN_WASM_INLINE __m128i _mm_loadu_si128(const __m128i* at) {
  return wasm_v128_load(at);
}
CAIRN_WASM_INLINE void _mm_storeu_si128(__m128i* at, __m128i v) {
  wasm_v128_store(at, v);
}
CAIRN_WASM_INLINE __m128i _mm_set_epi32(int d, int c, int b, int a) {
  return wasm_i32x4_make(a, b, c, d);
}
CAIRN_WASM_INLINE __m128i _mm_unpacklo_epi16(__m128i a, __m128i b) {
  return wasm_i16x8_shuffle(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
CAIRN_WASM_INLINE __m128i _mm_unpackhi_epi16(__m128i a, __m128i b) {
  return wasm_i16x8_shuffle(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
CAIRN_WASM_INLINE __m128i _mm_unpacklo_epi32(__m128i a, __m128i b) {
  return wasm_i32x4_shuffle(a, b, 0, 4, 1, 5);
}
CAIRN_WASM_INLINE __m128i _mm_unpackhi_epi32(__m128i a, __m128i b) {
  return wasm_i32x4_shuffle(a, b, 2, 6, 3, 7);
}
CAIRN_WASM_INLINE __m128i _mm_unpacklo_epi64(__m128i a, __m128i b) {
  return wasm_i64x2_shuffle(a, b, 0, 2);
}
CAIRN_WASM_INLINE __m128i _mm_unpackhi_epi64(__m128i a, __m128i b) {
  return wasm_i64x2_shuffle(a, b, 1, 3);
}

// --- 256 bits, half by half. ---

#define CAIRN_WASM_UNARY(name, operation)         \
  CAIRN_WASM_INLINE __m256i name(__m256i v) {     \
    return {operation(v.low), operation(v.high)}; \
  }
#define CAIRN_WASM_BINARY(name, operation)                       \
  CAIRN_WASM_INLINE __m256i name(__m256i a, __m256i b) {         \
    return {operation(a.low, b.low), operation(a.high, b.high)}; \
  }
#define CAIRN_WASM_SHIFT(name, operation)                         \
  CAIRN_WASM_INLINE __m256i name(__m256i v, int bits) {           \
    return {operation(v.low, static_cast<std::uint32_t>(bits)),   \
            operation(v.high, static_cast<std::uint32_t>(bits))}; \
  }

CAIRN_WASM_BINARY(_mm256_add_epi16, wasm_i16x8_add)
CAIRN_WASM_BINARY(_mm256_sub_epi16, wasm_i16x8_sub)
CAIRN_WASM_BINARY(_mm256_add_epi32, wasm_i32x4_add)
CAIRN_WASM_BINARY(_mm256_mullo_epi32, wasm_i32x4_mul)
CAIRN_WASM_BINARY(_mm256_madd_epi16, wasm_i32x4_dot_i16x8)
CAIRN_WASM_BINARY(_mm256_and_si256, wasm_v128_and)
CAIRN_WASM_BINARY(_mm256_or_si256, wasm_v128_or)
CAIRN_WASM_BINARY(_mm256_xor_si256, wasm_v128_xor)
CAIRN_WASM_BINARY(_mm256_cmpeq_epi16, wasm_i16x8_eq)
CAIRN_WASM_BINARY(_mm256_cmpgt_epi16, wasm_i16x8_gt)
CAIRN_WASM_BINARY(_mm256_cmpeq_epi32, wasm_i32x4_eq)
CAIRN_WASM_BINARY(_mm256_cmpgt_epi32, wasm_i32x4_gt)
CAIRN_WASM_BINARY(_mm256_min_epu16, wasm_u16x8_min)
CAIRN_WASM_BINARY(_mm256_avg_epu16, wasm_u16x8_avgr)
CAIRN_WASM_BINARY(_mm256_shuffle_epi8, wasm_i8x16_swizzle)
CAIRN_WASM_UNARY(_mm256_abs_epi16, wasm_i16x8_abs)
CAIRN_WASM_SHIFT(_mm256_slli_epi32, wasm_i32x4_shl)
CAIRN_WASM_SHIFT(_mm256_srli_epi32, wasm_u32x4_shr)
CAIRN_WASM_SHIFT(_mm256_srai_epi32, wasm_i32x4_shr)
CAIRN_WASM_SHIFT(_mm256_srli_epi16, wasm_u16x8_shr)

#undef CAIRN_WASM_UNARY
#undef CAIRN_WASM_BINARY
#undef CAIRN_WASM_SHIFT

CAIRN_WASM_INLINE __m256i _mm256_setzero_si256() {
  return {wasm_i32x4_const_splat(0), wasm_i32x4_const_splat(0)};
}
CAIRN_WASM_INLINE __m256i _mm256_set1_epi32(int value) {
  return {wasm_i32x4_splat(value), wasm_i32x4_splat(value)};
}
CAIRN_WASM_INLINE __m256i _mm256_set1_epi16(short value) {
  return {wasm_i16x8_splat(value), wasm_i16x8_splat(value)};
}
CAIRN_WASM_INLINE __m256i _mm256_load_si256(const __m256i* at) {
  return *at;
}
CAIRN_WASM_INLINE void _mm256_store_si256(__m256i* at, __m256i v) {
  *at = v;
}
CAIRN_WASM_INLINE void _mm256_storeu_si256(__m256i* at, __m256i v) {
  std::memcpy(static_cast<void*>(at), &v, sizeof v);
}
CAIRN_WASM_INLINE __m256i _mm256_castsi128_si256(__m128i v) {
  return {v, v};
}
CAIRN_WASM_INLINE __m128i _mm256_castsi256_si128(__m256i v) {
  return v.low;
}
CAIRN_WASM_INLINE __m256i _mm256_castsi256_ps(__m256i v) {
  return v;
}
CAIRN_WASM_INLINE __m256i _mm256_broadcastsi128_si256(__m128i v) {
  return {v, v};
}
CAIRN_WASM_INLINE __m128i _mm256_extracti128_si256(__m256i v, int half) {
  return half == 0 ? v.low : v.high;
}
CAIRN_WASM_INLINE __m256i _mm256_inserti128_si256(__m256i v, __m128i part, int half) {
  return half == 0 ? __m256i{part, v.high} : __m256i{v.low, part};
}
CAIRN_WASM_INLINE __m256i _mm256_cvtepi16_epi32(__m128i v) {
  return {wasm_i32x4_extend_low_i16x8(v), wasm_i32x4_extend_high_i16x8(v)};
}
CAIRN_WASM_INLINE int _mm256_movemask_epi8(__m256i v) {
  return static_cast<int>(static_cast<std::uint32_t>(wasm_i8x16_bitmask(v.low)) |
                          static_cast<std::uint32_t>(wasm_i8x16_bitmask(v.high)) << 16);
}
CAIRN_WASM_INLINE int _mm256_movemask_ps(__m256i v) {
  return static_cast<int>(wasm_i32x4_bitmask(v.low) | wasm_i32x4_bitmask(v.high) << 4);
}

/// REQUIRES: each byte of the mask is 0 or 255.
CAIRN_WASM_INLINE __m256i _mm256_blendv_epi8(__m256i a, __m256i b, __m256i mask) {
  return {wasm_v128_bitselect(b.low, a.low, mask.low), wasm_v128_bitselect(b.high, a.high, mask.high)};
}
/// REQUIRES: `lanes` is 0xAA: the odd ones come from `b`.
CAIRN_WASM_INLINE __m256i _mm256_blend_epi16(__m256i a, __m256i b, int lanes) {
  (void)lanes;
  return {wasm_i16x8_shuffle(a.low, b.low, 0, 9, 2, 11, 4, 13, 6, 15),
          wasm_i16x8_shuffle(a.high, b.high, 0, 9, 2, 11, 4, 13, 6, 15)};
}
/// REQUIRES: 12 or 14 bytes.
CAIRN_WASM_INLINE __m256i _mm256_alignr_epi8(__m256i a, __m256i b, int bytes) {
  const auto one = [bytes](v128_t high, v128_t low) __attribute__((always_inline)) {
    return bytes == 12 ? wasm_i32x4_shuffle(low, high, 3, 4, 5, 6)
                       : wasm_i16x8_shuffle(low, high, 7, 8, 9, 10, 11, 12, 13, 14);
  };
  return {one(a.low, b.low), one(a.high, b.high)};
}

// --- What WebAssembly has no operation for. ---

/// REQUIRES: counts below 8.
CAIRN_WASM_INLINE __m256i _mm256_srlv_epi32(__m256i v, __m256i counts) {
  const auto step = [](v128_t value, v128_t count, int bits) __attribute__((always_inline)) {
    const v128_t bit = wasm_i32x4_splat(bits);
    return wasm_v128_bitselect(wasm_u32x4_shr(value, static_cast<std::uint32_t>(bits)), value,
                               wasm_i32x4_eq(wasm_v128_and(count, bit), bit));
  };
  const auto one = [step](v128_t value, v128_t count) __attribute__((always_inline)) {
    return step(step(step(value, count, 1), count, 2), count, 4);
  };
  return {one(v.low, counts.low), one(v.high, counts.high)};
}
/// REQUIRES: counts of 0 or 16.
CAIRN_WASM_INLINE __m256i _mm256_sllv_epi32(__m256i v, __m256i counts) {
  const auto one = [](v128_t value, v128_t count) {
    return wasm_v128_bitselect(wasm_i32x4_shl(value, 16), value,
                               wasm_i32x4_ne(count, wasm_i32x4_const_splat(0)));
  };
  return {one(v.low, counts.low), one(v.high, counts.high)};
}
/// REQUIRES: places of 0 to 7.
CAIRN_WASM_INLINE __m256i _mm256_permutevar8x32_epi32(__m256i table, __m256i places) {
  // Eight small numbers: as bytes, the whole table is one shuffle away.
  const auto pick = [&table](v128_t place) {
    const v128_t bytes =
        wasm_i8x16_shuffle(table.low, table.high, 0, 4, 8, 12, 16, 20, 24, 28, 0, 0, 0, 0, 0, 0, 0, 0);
    // A lane's byte 0 is its place; the others name a byte that is not there, which gives 0.
    return wasm_i8x16_swizzle(bytes,
                              wasm_v128_or(place, wasm_i32x4_const_splat(static_cast<int>(0x80808000u))));
  };
  return {pick(places.low), pick(places.high)};
}
/// REQUIRES: scale 4.
CAIRN_WASM_INLINE __m256i _mm256_i32gather_epi32(const int* base, __m256i index, int scale) {
  (void)scale;
  const auto one = [base](v128_t i) {
    return wasm_i32x4_make(base[wasm_i32x4_extract_lane(i, 0)], base[wasm_i32x4_extract_lane(i, 1)],
                           base[wasm_i32x4_extract_lane(i, 2)], base[wasm_i32x4_extract_lane(i, 3)]);
  };
  return {one(index.low), one(index.high)};
}

}  // namespace cairn::wavefront

#endif
