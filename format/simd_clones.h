#pragma once

// For loops that the compiler can make vectors of: compiled for the baseline CPU and again for AVX2, and
// chosen between when the program starts. All give the same bits: no fused multiply-add, no reordering of
// floating point. ThreadSanitizer's runtime starts after that choice, which it cannot stand, so under it the
// baseline runs. CAIRN_SIMD_CLONES_512 also for AVX-512: for loops over 16 numbers, where that was measured
// to pay. It does not everywhere.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_SIMD_CLONES __attribute__((target_clones("avx2", "default")))
#define CAIRN_SIMD_CLONES_512 __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CAIRN_SIMD_CLONES
#define CAIRN_SIMD_CLONES_512
#endif
