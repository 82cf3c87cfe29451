#include "runtime/lod/mesh/square_errors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/vertex_errors.h"

namespace cairn {
namespace {

constexpr int kDroppedBits = 15;  // of a float: its sign is 0, so that sixteen are left

std::int32_t bits_of(float length) {
  return std::bit_cast<std::int32_t>(length);
}

}  // namespace

std::uint16_t round_up(float length_m) {
  assert(length_m >= 0 && length_m < 1e30f);
  return static_cast<std::uint16_t>((bits_of(length_m) + (1 << kDroppedBits) - 1) >> kDroppedBits);
}

int round_down(float length_m) {
  return length_m >= 0 ? bits_of(length_m) >> kDroppedBits : -1;
}

SquareErrors::SquareErrors(const LodScene& scene, const LodTile& tile, bool between_samples)
    : positions_(south_west_of(tile.source), lattice_width(tile.source.level) / (tile.heights->size - 1),
                 tile.heights->size),
      levels_(std::bit_width(static_cast<unsigned>(tile.heights->size - 1)) - 1) {
  const HeightTile& heights = *tile.heights;
  const double cell = tile_width_degrees(tile.source.level) / (heights.size - 1) * std::numbers::pi / 180;
  chord_of_cell_m_ = cairn::chord_of_cell_m(cell, tile.max_m);
  std::size_t squares = 0;
  for (int k = levels_; k >= 1; --k) {
    first_[static_cast<std::size_t>(k)] = squares;
    squares += std::size_t{1} << (2 * (levels_ - k));
  }
  squares_.resize(squares);
  fill(heights, vertex_errors_m(heights, tile.source, scene.quantum_m, between_samples));
  place_spheres(heights, scene.quantum_m);
}

void SquareErrors::fill(const HeightTile& heights, const std::vector<float>& errors_m) {
  const auto error = [&](int c, int r) {
    return errors_m[static_cast<std::size_t>(r) * static_cast<std::size_t>(heights.size) +
                    static_cast<std::size_t>(c)];
  };
  for (int k = 1; k <= levels_; ++k) {
    const int h = 1 << (k - 1);
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        SquareError& square = squares_[slot(k, x, y)];
        const int c = (2 * x + 1) * h, r = (2 * y + 1) * h;
        square.centre = round_up(error(c, r));
        square.middles = {round_up(error(c, r - h)), round_up(error(c + h, r)), round_up(error(c, r + h)),
                          round_up(error(c - h, r))};
        square.below =
            std::max(square.centre, *std::max_element(square.middles.begin(), square.middles.end()));
        for (int q = 0; k > 1 && q < 4; ++q)
          square.below = std::max(square.below, at(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1)).below);
      }
    }
  }
}

void SquareErrors::place_spheres(const HeightTile& heights, double quantum_m) {
  const int least = std::min(kSphereLevel, levels_);
  middle_ = positions_.at(heights.size / 2, heights.size / 2, 0);
  spheres_.resize(slot(least, (1 << (levels_ - least)) - 1, (1 << (levels_ - least)) - 1) + 1);
  std::vector<std::array<double, 2>> ranges(spheres_.size());
  for (int k = least; k <= levels_; ++k) {
    const int s = 1 << k;
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        auto& [low, high] = ranges[slot(k, x, y)];
        low = HUGE_VAL, high = -HUGE_VAL;
        if (k == least) {
          for (int r = y * s; r <= (y + 1) * s; ++r) {
            for (int c = x * s; c <= (x + 1) * s; ++c) {
              low = std::min(low, heights.at(c, r) * quantum_m);
              high = std::max(high, heights.at(c, r) * quantum_m);
            }
          }
        } else {
          for (int q = 0; q < 4; ++q) {
            const auto& inner = ranges[slot(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1))];
            low = std::min(low, inner[0]);
            high = std::max(high, inner[1]);
          }
        }
        spheres_[slot(k, x, y)] = near_sphere(sphere_over(k, x, y, low, high));
      }
    }
  }
}

SquareSphere SquareErrors::sphere_over(int k, int x, int y, double low_m, double high_m) const {
  const int s = 1 << k;
  SquareSphere sphere{positions_.at(x * s + s / 2, y * s + s / 2, (low_m + high_m) / 2), 0};
  for (int q = 0; q < 4; ++q) {
    for (const double height_m : {low_m, high_m}) {
      const glm::dvec3 corner = positions_.at((x + (q & 1)) * s, (y + (q >> 1)) * s, height_m);
      sphere.radius_m = std::max(sphere.radius_m, glm::length(corner - sphere.centre));
    }
  }
  sphere.radius_m += chord_m(k);
  return sphere;
}

SquareErrors::NearSphere SquareErrors::near_sphere(const SquareSphere& sphere) const {
  const glm::vec3 centre(sphere.centre - middle_);
  const double lost = glm::length(glm::dvec3(centre) + middle_ - sphere.centre);
  return {centre, std::nextafter(static_cast<float>(sphere.radius_m + lost), HUGE_VALF)};
}

SquareSphere SquareErrors::sphere(int k, int x, int y) const {
  const int up = std::max(0, std::min(kSphereLevel, levels_) - k);
  const NearSphere& near = spheres_[slot(k + up, x >> up, y >> up)];
  return {middle_ + glm::dvec3(near.centre), static_cast<double>(near.radius_m)};
}

std::uint64_t SquareErrors::bytes() const {
  return positions_.bytes() + squares_.size() * sizeof(SquareError) + spheres_.size() * sizeof(NearSphere);
}

}  // namespace cairn
