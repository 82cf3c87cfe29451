#include "runtime/lod/mesh/square_errors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/surface/vertex_errors.h"

namespace cairn {
namespace {

constexpr int kDroppedBits = 15;  // a length's sign bit is 0, so that sixteen bits of the float are left

std::int32_t bits_of(float length) {
  return std::bit_cast<std::int32_t>(length);
}

}  // namespace

std::uint16_t encode_rounding_up(float length_m) {
  assert(length_m >= 0 && length_m < 1e30f);
  return static_cast<std::uint16_t>((bits_of(length_m) + (1 << kDroppedBits) - 1) >> kDroppedBits);
}

int encode_rounding_down(float length_m) {
  return length_m >= 0 ? bits_of(length_m) >> kDroppedBits : -1;
}

SquareErrors::SquareErrors(const LodScene& scene, const LodTile& tile, bool between_samples)
    : positions_(south_west_of(tile.source), lattice_width(tile.source.level) / (tile.heights->size - 1),
                 tile.heights->size, scene.ellipsoid),
      levels_(std::bit_width(static_cast<unsigned>(tile.heights->size - 1)) - 1),
      cell_radians_(tile_width_degrees(tile.source.level) / (tile.heights->size - 1) * std::numbers::pi /
                    180),
      cell_m_(cell_radians_ * scene.ellipsoid.semi_major_m) {
  const HeightTile& heights = *tile.heights;
  std::size_t squares = 0;
  for (int k = levels_; k >= 1; --k) {
    first_[static_cast<std::size_t>(k)] = squares;
    squares += std::size_t{1} << (2 * (levels_ - k));
  }
  squares_.resize(squares);
  fill(heights, vertex_errors_m(heights, tile.source, scene.quantum_m, between_samples));
  const std::vector<std::array<double, 2>> ranges = height_ranges_m(heights, scene.quantum_m);
  measure_sagittas(ranges, tile.max_m, scene.ellipsoid);
  place_spheres(heights, ranges);
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
        square.centre = encode_rounding_up(error(c, r));
        square.middles = {encode_rounding_up(error(c, r - h)), encode_rounding_up(error(c + h, r)),
                          encode_rounding_up(error(c, r + h)), encode_rounding_up(error(c - h, r))};
        square.max_within =
            std::max(square.centre, *std::max_element(square.middles.begin(), square.middles.end()));
        for (int q = 0; k > 1 && q < 4; ++q)
          square.max_within =
              std::max(square.max_within, at(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1)).max_within);
      }
    }
  }
}

/// Returns the least and the largest height in each square that has a sphere, by slot.
std::vector<std::array<double, 2>> SquareErrors::height_ranges_m(const HeightTile& heights,
                                                                 double quantum_m) const {
  const int least = std::min(kSphereLevel, levels_);
  std::vector<std::array<double, 2>> ranges(
      slot(least, (1 << (levels_ - least)) - 1, (1 << (levels_ - least)) - 1) + 1);
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
      }
    }
  }
  return ranges;
}

void SquareErrors::measure_sagittas(const std::vector<std::array<double, 2>>& ranges, double highest_m,
                                    const Ellipsoid& ellipsoid) {
  /// 0.39 times the longer leg is the bound. A triangle bisected at a middle has legs 1/√2 as long as one
  /// bisected at a centre, but uses half of sagitta_m(); √2 makes that half large enough.
  constexpr double kLean = 0.39 * std::numbers::sqrt2;
  const double of_cell = sagitta_of_cell_m(cell_radians_, highest_m, ellipsoid);
  for (int k = 0; k <= levels_; ++k) {
    const int ranged = std::max(k, std::min(kSphereLevel, levels_)), side = 1 << (levels_ - ranged);
    double rise = 0;
    for (std::size_t i = slot(ranged, 0, 0); i <= slot(ranged, side - 1, side - 1); ++i)
      rise = std::max(rise, ranges[i][1] - ranges[i][0]);
    const double cells = 1 << k;
    sagittas_m_[static_cast<std::size_t>(k)] = of_cell * cells * cells + kLean * rise * cells * cell_radians_;
  }
}

void SquareErrors::place_spheres(const HeightTile& heights,
                                 const std::vector<std::array<double, 2>>& ranges) {
  middle_ = positions_.at(heights.size / 2, heights.size / 2, 0);
  spheres_.resize(ranges.size());
  for (int k = std::min(kSphereLevel, levels_); k <= levels_; ++k) {
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        const auto& [low, high] = ranges[slot(k, x, y)];
        spheres_[slot(k, x, y)] = local_sphere(sphere_over(k, x, y, low, high));
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
  sphere.radius_m += sagitta_m(k);
  return sphere;
}

SquareErrors::LocalSphere SquareErrors::local_sphere(const SquareSphere& sphere) const {
  const glm::vec3 centre(sphere.centre - middle_);
  const double lost = glm::length(glm::dvec3(centre) + middle_ - sphere.centre);
  return {centre, std::nextafter(static_cast<float>(sphere.radius_m + lost), HUGE_VALF)};
}

SquareSphere SquareErrors::sphere(int k, int x, int y) const {
  const int up = std::max(0, std::min(kSphereLevel, levels_) - k);
  const LocalSphere& local = spheres_[slot(k + up, x >> up, y >> up)];
  return {middle_ + glm::dvec3(local.centre), static_cast<double>(local.radius_m)};
}

std::uint64_t SquareErrors::bytes() const {
  return positions_.bytes() + squares_.size() * sizeof(SquareError) + spheres_.size() * sizeof(LocalSphere);
}

}  // namespace cairn
