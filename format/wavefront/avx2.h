#pragma once

// For the files that hold code for AVX2. It runs only where cpu_has_avx2(), and gives what the portable code
// gives. WebAssembly with vectors runs the decoder's as well.

#if defined(__x86_64__)

#include <cpuid.h>
#include <immintrin.h>

#define CAIRN_AVX2 __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt")))
#define CAIRN_AVX2_DECODER

namespace cairn::wavefront {

/// Clang 14 knows no "lzcnt" in __builtin_cpu_supports: the processor is asked itself (CPUID 80000001h, ECX
/// bit 5).
inline bool cpu_has_lzcnt() {
  unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
  return __get_cpuid(0x80000001, &eax, &ebx, &ecx, &edx) != 0 && (ecx >> 5 & 1) != 0;
}

/// Asks once: CPUID leaves a virtual machine, which takes microseconds.
inline bool cpu_has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                          __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt") &&
                          cpu_has_lzcnt();
  return has;
}

}  // namespace cairn::wavefront

#elif defined(__wasm_simd128__)

#include "format/wavefront/avx2_wasm.h"

#define CAIRN_AVX2
#define CAIRN_AVX2_DECODER

namespace cairn::wavefront {

inline bool cpu_has_avx2() {
  return true;
}

}  // namespace cairn::wavefront

#endif

#if defined(CAIRN_AVX2_DECODER)

#define CAIRN_AVX2_INLINE CAIRN_AVX2 inline __attribute__((always_inline))

namespace cairn::wavefront {

/// Transposes 16-bit values: row i of the result is column i of the rows.
CAIRN_AVX2_INLINE void transpose8(const __m128i (&rows)[8], __m128i (&columns)[8]) {
  __m128i a[8], b[8];
  for (int i = 0; i < 4; ++i) {
    a[2 * i] = _mm_unpacklo_epi16(rows[2 * i], rows[2 * i + 1]);
    a[2 * i + 1] = _mm_unpackhi_epi16(rows[2 * i], rows[2 * i + 1]);
  }
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      b[4 * i + 2 * j] = _mm_unpacklo_epi32(a[4 * i + j], a[4 * i + 2 + j]);
      b[4 * i + 2 * j + 1] = _mm_unpackhi_epi32(a[4 * i + j], a[4 * i + 2 + j]);
    }
  }
  for (int i = 0; i < 4; ++i) {
    columns[2 * i] = _mm_unpacklo_epi64(b[i], b[4 + i]);
    columns[2 * i + 1] = _mm_unpackhi_epi64(b[i], b[4 + i]);
  }
}

}  // namespace cairn::wavefront

#endif
