#include "builder/texture_encode/bc1_holes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace cairn {

namespace {

using Colour = std::array<double, 3>;

// A texel that is no hole.
struct Texel {
  Colour colour;
  unsigned number;
};

// Ends and the position of each texel between them: 0, 1 (half way), 2.
struct Fit {
  std::array<unsigned, 2> ends{};
  std::vector<int> positions;
  double error = std::numeric_limits<double>::infinity();
};

double dot(const Colour& a, const Colour& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

unsigned pack_565(const Colour& colour) {
  const auto nearest = [](double value, int steps) {
    return static_cast<unsigned>(std::clamp(value, 0.0, 255.0) * steps / 255 + 0.5);
  };
  return nearest(colour[0], 31) << 11 | nearest(colour[1], 63) << 5 | nearest(colour[2], 31);
}

Colour unpack_565(unsigned packed) {
  const unsigned r = packed >> 11, g = packed >> 5 & 63, b = packed & 31;
  return {static_cast<double>(r << 3 | r >> 2), static_cast<double>(g << 2 | g >> 4),
          static_cast<double>(b << 3 | b >> 2)};
}

Fit nearest_positions(const std::vector<Texel>& texels, const Colour& end0, const Colour& end1) {
  Fit fit{{pack_565(end0), pack_565(end1)}, {}, 0};
  const Colour a = unpack_565(fit.ends[0]), b = unpack_565(fit.ends[1]);
  for (const Texel& texel : texels) {
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int position = 0; position < 3; ++position) {
      double squared = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double off = texel.colour[c] - (a[c] + (b[c] - a[c]) * position / 2);
        squared += off * off;
      }
      if (squared < least) least = squared, nearest = position;
    }
    fit.positions.push_back(nearest);
    fit.error += least;
  }
  return fit;
}

// Least squares: the ends that suit the positions best.
Fit refit(const std::vector<Texel>& texels, const Fit& from) {
  const double n = static_cast<double>(texels.size());
  double p = 0, pp = 0;
  Colour sum{}, products{};
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const double position = from.positions[i];
    p += position;
    pp += position * position;
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += texels[i].colour[c];
      products[c] += position * texels[i].colour[c];
    }
  }
  const double spread = n * pp - p * p;
  if (spread == 0) return from;
  Colour end0{}, end1{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double slope = (n * products[c] - p * sum[c]) / spread;
    end0[c] = (sum[c] - slope * p) / n;
    end1[c] = end0[c] + 2 * slope;
  }
  return nearest_positions(texels, end0, end1);
}

// The two texels that lie farthest apart: with sixteen, all pairs can be tried.
Fit first_fit(const std::vector<Texel>& texels) {
  Colour end0 = texels.front().colour, end1 = end0;
  double farthest = 0;
  for (const Texel& a : texels) {
    for (const Texel& b : texels) {
      const Colour apart = {a.colour[0] - b.colour[0], a.colour[1] - b.colour[1], a.colour[2] - b.colour[2]};
      if (dot(apart, apart) > farthest) farthest = dot(apart, apart), end0 = a.colour, end1 = b.colour;
    }
  }
  return nearest_positions(texels, end0, end1);
}

std::array<std::byte, 8> pack(const std::vector<Texel>& texels, const Fit& fit) {
  // Positions 0, 1, 2 are indices 0, 2, 1 where the ends ascend, as this mode wants them; 3 is a hole.
  const bool swapped = fit.ends[0] > fit.ends[1];
  std::uint32_t indices = 0xFFFFFFFF;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const int position = swapped ? 2 - fit.positions[i] : fit.positions[i];
    const std::uint32_t index = position == 0 ? 0U : position == 1 ? 2U : 1U;
    const unsigned shift = 2 * texels[i].number;
    indices = (indices & ~(3U << shift)) | index << shift;
  }
  const std::uint32_t ends = swapped ? fit.ends[1] | fit.ends[0] << 16 : fit.ends[0] | fit.ends[1] << 16;
  const std::uint32_t halves[2] = {ends, indices};
  std::array<std::byte, 8> block;
  std::memcpy(block.data(), halves, 8);
  return block;
}

}  // namespace

std::array<std::byte, 8> encode_bc1_holes(const std::uint8_t* texels, std::ptrdiff_t stride) {
  std::vector<Texel> seen;
  for (unsigned i = 0; i < 16; ++i) {
    const std::uint8_t* texel = texels + i / 4 * stride + i % 4 * 4;
    if (texel[3] < 128) continue;
    seen.push_back(
        {{static_cast<double>(texel[0]), static_cast<double>(texel[1]), static_cast<double>(texel[2])}, i});
  }
  Fit best;
  if (!seen.empty()) best = first_fit(seen);
  for (int round = 0; round < 3 && !seen.empty(); ++round) {
    Fit other = refit(seen, best);
    if (!(other.error < best.error)) break;
    best = std::move(other);
  }
  return pack(seen, best);
}

}  // namespace cairn
