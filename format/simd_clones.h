#pragma once

// Compiles a function for the baseline CPU and again for AVX2; the program chooses when it starts. It is for
// loops that the compiler can make vectors of. All versions give equal bits: there is no fused multiply-add
// and no reordering of floating point. ThreadSanitizer's runtime starts after the choice and does not survive
// it, so the baseline runs under it; so it does on Windows, whose linker has no such choice.
// CAIRN_SIMD_CLONES_512 adds a version for AVX-512, for loops over 16 numbers. CAIRN_SIMD_CLONES_TEMPLATE is
// for templates, which Clang 14 compiles for the baseline only.
#if defined(__x86_64__) && defined(__ELF__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_SIMD_CLONES __attribute__((target_clones("avx2", "default")))
#define CAIRN_SIMD_CLONES_512 __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CAIRN_SIMD_CLONES
#define CAIRN_SIMD_CLONES_512
#endif
#if defined(__clang__)
#define CAIRN_SIMD_CLONES_TEMPLATE
#else
#define CAIRN_SIMD_CLONES_TEMPLATE CAIRN_SIMD_CLONES
#endif
