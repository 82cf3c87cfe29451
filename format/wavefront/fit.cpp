#include "format/wavefront/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "format/wavefront/avx2.h"

#define CAIRN_INLINE inline __attribute__((always_inline))

namespace cairn::wavefront {
namespace {

/// Unknowns: all weights but west's. Everything is measured from the western neighbour and west's weight
/// makes the sum one, so that a tile's height above its base does not matter.
constexpr std::size_t kUnknowns = kTaps - 1;
constexpr std::size_t kColumns = kUnknowns + 1;  // and what they should give

/// Sums run in eight interleaved parts, which compilers turn into one vector; their order is thereby fixed.
constexpr std::size_t kParts = 8;
constexpr std::size_t kChunk = 64;

constexpr unsigned kShare = 8;  // one chunk of so many is looked at

using Columns = std::array<std::array<float, kChunk>, kColumns>;
using Sums = std::array<std::array<double, kColumns>, kColumns>;

struct Chunk {
  Columns plain;
  Columns weighted;
};

/// How much a sample counts: 1/(1 + a²/2), a = mean magnitude of the mixed second differences at the four
/// neighbours that are coded before.
CAIRN_INLINE float trust(const std::int16_t* s, std::ptrdiff_t width) {
  const auto mixed = [&](std::ptrdiff_t at) __attribute__((always_inline)) {
    return std::abs(s[at] - s[at - 1] - s[at - width] + s[at - width - 1]);
  };
  const int rough = 2 * mixed(-1) + 2 * mixed(-width) + mixed(-width - 1) + mixed(-width + 1);
  const float mean = static_cast<float>(rough) * (1.0f / 6.0f);
  return 1.0f / (1.0f + mean * mean * 0.5f);
}

CAIRN_INLINE void fill_chunk(const std::int16_t* row, std::size_t count, std::ptrdiff_t width,
                             const std::array<std::ptrdiff_t, kTaps>& offsets, Chunk& chunk) {
  std::array<float, kChunk> trusts{};
  for (std::size_t i = 0; i < count; ++i) trusts[i] = trust(row + i, width);
  std::size_t column = 0;
  for (std::size_t tap = 0; tap <= kTaps; ++tap) {
    if (tap == kWestTap) continue;
    const std::ptrdiff_t offset = tap < kTaps ? offsets[tap] : 0;
    auto& plain = chunk.plain[column];
    auto& weighted = chunk.weighted[column++];
    for (std::size_t i = 0; i < count; ++i) plain[i] = static_cast<float>(row[i + offset] - row[i - 1]);
    for (std::size_t i = count; i < kChunk; ++i) plain[i] = 0;
    for (std::size_t i = 0; i < kChunk; ++i) weighted[i] = plain[i] * trusts[i];
  }
}

CAIRN_INLINE float dot(const float* a, const float* b) {
  std::array<float, kParts> parts{};
  for (std::size_t i = 0; i < kChunk; i += kParts) {
    for (std::size_t p = 0; p < kParts; ++p) parts[p] += a[i + p] * b[i + p];
  }
  return ((parts[0] + parts[1]) + (parts[2] + parts[3])) + ((parts[4] + parts[5]) + (parts[6] + parts[7]));
}

using Offsets = std::array<std::ptrdiff_t, kTaps>;

CAIRN_INLINE void add_samples(const std::int16_t* samples, std::size_t count, std::ptrdiff_t width,
                              const Offsets& offsets, Sums& sums) {
  Chunk chunk;
  fill_chunk(samples, count, width, offsets, chunk);
  for (std::size_t i = 0; i < kColumns; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      sums[i][j] += static_cast<double>(dot(chunk.weighted[i].data(), chunk.plain[j].data()));
    }
  }
}

using AddSamples = void (*)(const std::int16_t*, std::size_t, std::ptrdiff_t, const Offsets&, Sums&);

void add_samples_portable(const std::int16_t* samples, std::size_t count, std::ptrdiff_t width,
                          const Offsets& offsets, Sums& sums) {
  add_samples(samples, count, width, offsets, sums);
}

#if defined(__x86_64__)
/// The same operations in the same order, eight at a time.
CAIRN_AVX2 void add_samples_avx2(const std::int16_t* samples, std::size_t count, std::ptrdiff_t width,
                                 const Offsets& offsets, Sums& sums) {
  add_samples(samples, count, width, offsets, sums);
}
#endif

/// Solves the normal equations by Cholesky's method, in place. The ridge keeps flat and featureless tiles
/// solvable.
std::array<double, kUnknowns> solve(Sums& a) {
  double trace = 0;
  for (std::size_t i = 0; i < kUnknowns; ++i) trace += a[i][i];
  std::array<double, kUnknowns> x{};
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    a[i][i] += 1e-7 * trace + 1e-3;
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = a[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
    }
    double sum = a[kUnknowns][i];
    for (std::size_t k = 0; k < i; ++k) sum -= a[i][k] * x[k];
    x[i] = sum / a[i][i];
  }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t k = i + 1; k < kUnknowns; ++k) x[i] -= a[k][i] * x[k];
    x[i] /= a[i][i];
  }
  return x;
}

Weights rounded(const std::array<double, kUnknowns>& solution) {
  Weights weights{};
  int west = 1 << kWeightBits;
  std::size_t next = 0;
  for (std::size_t tap = 0; tap < kTaps; ++tap) {
    if (tap == kWestTap) continue;
    const double scaled = solution[next++] * (1 << kWeightBits);
    // Written so that a weight that is no number counts as 0.
    const int weight = std::abs(scaled) < 16000 ? static_cast<int>(std::lrint(scaled)) : 0;
    weights[tap] = static_cast<std::int16_t>(weight);
    west -= weight;
  }
  weights[kWestTap] = static_cast<std::int16_t>(std::clamp(west, -32768, 32767));
  return weights;
}

Weights fit_with(AddSamples add, const Geometry& g, const Plane& plane) {
  const auto offsets = tap_offsets(g);
  Sums sums{};
  // Drawn by a small generator: sources have stripes with periods of a few rows or columns.
  std::uint32_t draw = 1;
  constexpr int kStride = static_cast<int>(kChunk);
  const int end = g.size - 2;  // the last columns' neighbours are partly virtual
  for (int row = 1; row < g.size; ++row) {
    const std::int16_t* samples = plane.data() + g.row_start(row) + kLeft;
    for (int c = 1; c < end; c += kStride) {
      draw = draw * 1664525u + 1013904223u;
      if ((draw >> 16) % kShare != 0 && g.size > 64) continue;
      add(samples + c, static_cast<std::size_t>(std::min(kStride, end - c)), g.width, offsets, sums);
    }
  }
  return rounded(solve(sums));
}

}  // namespace

Weights fit_weights_portable(const Geometry& g, const Plane& plane) {
  return fit_with(add_samples_portable, g, plane);
}

Weights fit_weights(const Geometry& g, const Plane& plane) {
#if defined(__x86_64__)
  if (cpu_has_avx2()) return fit_with(add_samples_avx2, g, plane);
#endif
  return fit_weights_portable(g, plane);
}

}  // namespace cairn::wavefront
