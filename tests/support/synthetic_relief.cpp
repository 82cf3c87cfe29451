#include "tests/support/synthetic_relief.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace cairn::bench {
namespace {

constexpr int kTopDegrees = 16;              // the longest wave
constexpr double kCrestDegrees = 1.0 / 256;  // crests are cut at this scale; finer octaves roughen them
constexpr int kWidestCrest = 4;              // octaves below the longest wave: ranges a degree across
constexpr int kCrestOctaves = 8;
// Fine octaves fall off so fast that height differences grow 1.8-fold with each doubling of the distance, as
// they do (1.8 to 1.9) on SRTM's 1" and 3" mountains.
constexpr float kFallOff = 1.3F;
constexpr float kFineAmplitude = 70.0F;  // metres, of the octave below the crests'

/// Lattice values of one octave: (column, row) is the place (x + column, y + row) in steps of 2^octave posts.
struct Lattice {
  std::int64_t x = 0;
  std::int64_t y = 0;
  int columns = 0;
  int rows = 0;
  std::vector<float> values;

  Lattice(std::int64_t x_, std::int64_t y_, int columns_, int rows_)
      : x(x_),
        y(y_),
        columns(columns_),
        rows(rows_),
        values(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}
  float* row(int r) {
    return values.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
  const float* row(int r) const {
    return values.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
};

/// The coarser lattice from which this one can be refined.
Lattice parent_of(const Lattice& fine) {
  const std::int64_t x = (fine.x >> 1) - 1, y = (fine.y >> 1) - 1;
  const std::int64_t east = ((fine.x + fine.columns - 1) >> 1) + 2,
                     north = ((fine.y + fine.rows - 1) >> 1) + 2;
  return {x, y, static_cast<int>(east - x + 1), static_cast<int>(north - y + 1)};
}

void refine_row(const float* coarse, std::int64_t coarse_x, const Lattice& fine, float* out) {
  for (int c = 0; c < fine.columns; ++c) {
    const std::int64_t x = fine.x + c;
    const float* p = coarse + ((x >> 1) - coarse_x);
    out[c] = (x & 1) != 0 ? (p[0] + p[1]) * 0.5F : (p[-1] + p[1]) * 0.125F + p[0] * 0.75F;
  }
}

void refine(const Lattice& coarse, Lattice& fine) {
  std::vector<float> wide(static_cast<std::size_t>(fine.columns) * static_cast<std::size_t>(coarse.rows));
  const auto wide_row = [&](std::int64_t r) {
    return wide.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(fine.columns);
  };
  for (int r = 0; r < coarse.rows; ++r) refine_row(coarse.row(r), coarse.x, fine, wide_row(r));
  for (int r = 0; r < fine.rows; ++r) {
    const std::int64_t y = fine.y + r, at = (y >> 1) - coarse.y;
    const float *a = wide_row(at - 1), *b = wide_row(at), *c = wide_row(at + 1);
    float* out = fine.row(r);
    if ((y & 1) != 0) {
      for (int i = 0; i < fine.columns; ++i) out[i] = (b[i] + c[i]) * 0.5F;
    } else {
      for (int i = 0; i < fine.columns; ++i) out[i] = (a[i] + c[i]) * 0.125F + b[i] * 0.75F;
    }
  }
}

/// Even in -1…1, from an integer hash (the finaliser of MurmurHash3).
float noise(std::uint32_t row_hash, std::uint32_t x) {
  std::uint32_t h = row_hash ^ x * 0x9E3779B1u;
  h = (h ^ h >> 16) * 0x85EBCA6Bu;
  h = (h ^ h >> 13) * 0xC2B2AE35u;
  return static_cast<float>(static_cast<std::int32_t>(h ^ h >> 16)) * 0x1p-31F;
}

std::uint32_t row_hash(std::uint32_t seed, int octave, std::int64_t y) {
  std::uint32_t h =
      seed ^ static_cast<std::uint32_t>(octave) * 0x27D4EB2Fu ^ static_cast<std::uint32_t>(y) * 0x165667B1u;
  return (h ^ h >> 15) * 0x2C1B3C6Du;
}

void add_noise(Lattice& lattice, std::uint32_t seed, int octave, float amplitude) {
  for (int r = 0; r < lattice.rows; ++r) {
    const std::uint32_t hash = row_hash(seed, octave, lattice.y + r);
    float* out = lattice.row(r);
    const auto x = static_cast<std::uint32_t>(lattice.x);
    for (int c = 0; c < lattice.columns; ++c)
      out[c] += amplitude * noise(hash, x + static_cast<std::uint32_t>(c));
  }
}

/// The same, weighted at each place.
void add_noise(Lattice& lattice, std::uint32_t seed, int octave, float amplitude, const Lattice& weight) {
  for (int r = 0; r < lattice.rows; ++r) {
    const std::uint32_t hash = row_hash(seed, octave, lattice.y + r);
    float* out = lattice.row(r);
    const float* w = weight.row(r);
    const auto x = static_cast<std::uint32_t>(lattice.x);
    for (int c = 0; c < lattice.columns; ++c)
      out[c] += amplitude * w[c] * noise(hash, x + static_cast<std::uint32_t>(c));
  }
}

/// A smooth field on this octave, of waves from octave `top` down to `last`, each finer one weaker.
Lattice smooth_field(Lattice lattice, std::uint32_t seed, int octave, int top, int last, float fall_off) {
  if (octave < top) refine(smooth_field(parent_of(lattice), seed, octave + 1, top, last, fall_off), lattice);
  if (octave >= last) add_noise(lattice, seed, octave, std::pow(fall_off, static_cast<float>(top - octave)));
  return lattice;
}

float smooth_step(float from, float to, float v) {
  const float t = std::clamp((v - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

struct Ground {
  Lattice height;
  Lattice roughness;  // 0 plain … 1 mountains
};

/// Ridged multifractal, 0…1: crests where a smooth field crosses zero, finer ones on the flanks of wider ones
/// (Musgrave in Ebert et al., Texturing and Modeling, ch. 16).
Lattice crests(const Lattice& shape, std::uint32_t seed, int octave, int top) {
  Lattice sum = shape;
  std::vector<float> weight(shape.values.size(), 1.0F);
  float amplitude = 0.4F;
  for (int i = 0; i < kCrestOctaves && top - i >= octave; ++i) {
    const Lattice field =
        smooth_field(shape, seed + static_cast<std::uint32_t>(i), octave, top - i, top - i - 2, 0.5F);
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const float ridge = 1 - std::min(1.0F, std::abs(field.values[k]) * 2);
      const float signal = ridge * ridge * weight[k];
      sum.values[k] += amplitude * signal;
      weight[k] = std::min(1.0F, 0.25F + 1.5F * signal);
    }
    amplitude *= 0.68F;
  }
  return sum;
}

/// Sea, plains and ranges at the scale where crests are cut.
Ground coarse_ground(const Lattice& shape, std::uint32_t seed, int octave, int top) {
  Ground ground{shape, shape};
  const Lattice land = smooth_field(shape, seed, octave, top, top - 7, 0.55F);
  const Lattice rough = smooth_field(shape, seed + 1, octave, top - 2, top - 8, 0.6F);
  const Lattice ridges = crests(shape, seed + 16, octave, top - kWidestCrest);
  for (std::size_t i = 0; i < shape.values.size(); ++i) {
    const float continent = smooth_step(-0.25F, 0.25F, land.values[i]);
    const float mountains = smooth_step(-0.4F, 0.15F, rough.values[i]) * continent;
    const float ridge = ridges.values[i];
    ground.height.values[i] = 1100 * (continent - 0.4F) + mountains * (100 + 4200 * ridge);
    ground.roughness.values[i] = 0.02F + mountains * (0.3F + 0.7F * ridge);
  }
  return ground;
}

struct Octaves {
  std::uint32_t seed;
  int crest;  // the octave of coarse_ground
  int top;
};

Ground refined_ground(const Lattice& shape, const Octaves& octaves, int octave) {
  if (octave >= octaves.crest) return coarse_ground(shape, octaves.seed, octave, octaves.top);
  const Ground coarse = refined_ground(parent_of(shape), octaves, octave + 1);
  Ground fine{shape, shape};
  refine(coarse.height, fine.height);
  refine(coarse.roughness, fine.roughness);
  const float amplitude =
      kFineAmplitude * std::exp2(-kFallOff * static_cast<float>(octaves.crest - 1 - octave));
  add_noise(fine.height, octaves.seed + 3, octave, amplitude, fine.roughness);
  return fine;
}

int octave_of(double degrees, int posts_per_degree) {
  return std::max(0, static_cast<int>(std::lround(std::log2(degrees * posts_per_degree))));
}

}  // namespace

SyntheticRelief::SyntheticRelief(int posts_per_degree, std::uint32_t seed)
    : posts_per_degree_(posts_per_degree),
      top_octave_(octave_of(kTopDegrees, posts_per_degree)),
      seed_(seed) {
  assert(posts_per_degree >= 1);
}

void SyntheticRelief::heights(std::int64_t x, std::int64_t y, int columns, int rows,
                              std::span<std::int16_t> out) const {
  assert(out.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const int crest = octave_of(kCrestDegrees, posts_per_degree_);
  const Ground ground = refined_ground({x, y, columns, rows}, {seed_, crest, top_octave_}, 0);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<std::int16_t>(std::lrint(std::clamp(ground.height.values[i], 0.0F, 8000.0F)));
}

}  // namespace cairn::bench
