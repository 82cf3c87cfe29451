#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {

/// Returns the 16-bit code of a length: the upper half of a float, rounded up by at most 0.4 %.
/// Codes are ordered like lengths; 0 is the code of 0 only. REQUIRES: 0 <= length_m < 1e30.
std::uint16_t encode_rounding_up(float length_m);
/// Returns the largest code whose length is at most this; -1 for a negative length.
int encode_rounding_down(float length_m);
/// Returns the length of a code, in metres.
inline float decode_length_m(std::uint16_t code) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(code) << 15);
}

/// Codes of how far samples are, at most, from the triangles that are bisected at a square's vertices.
struct SquareError {
  std::uint16_t max_within = 0;  ///< the largest error of this square and of all squares within it
  std::uint16_t centre = 0;
  std::array<std::uint16_t, 4> middles{};  ///< of the south, east, north and west edge
};

/// The errors and bounding spheres of all squares of a tile's bisection hierarchy (BisectionForest).
///
/// Worked out once when a tile is loaded, and immutable after that. The errors are those of
/// vertex_errors_m(), without the body's curvature, for which sagitta_m() is the bound.
class SquareErrors {
 public:
  /// Squares of at least 2^kSphereLevel cells have spheres of their own.
  static constexpr int kSphereLevel = 2;

  SquareErrors(const LodScene& scene, const LodTile& tile, bool between_samples);

  int levels() const { return levels_; }  ///< log2 of the tile's cells
  const SquareError& at(int k, int x, int y) const { return squares_[slot(k, x, y)]; }
  /// Returns the sphere of the square, or of the smallest square around it that has one.
  SquareSphere sphere(int k, int x, int y) const;

  /// Returns the largest distance, in metres, between a flat triangle and the curved surface through its
  /// corners that has the triangle's heights: for triangles bisected at the centre of a square of 2^k cells.
  /// Triangles bisected at a middle have at most half of it.
  ///
  /// It is the sum of two bounds. A level triangle has sagitta_of_cell_m(). Where the corners' heights hᵢ
  /// differ, their normals nᵢ do too, which adds Σ wᵢwⱼ(hᵢ − hⱼ)(nᵢ − nⱼ) over the three pairs, wᵢ the
  /// barycentric weights: at most 0.39 times the longer leg in radians times the range of heights.
  double sagitta_m(int k) const { return sagittas_m_[static_cast<std::size_t>(k)]; }

  double cell_m() const { return cell_m_; }              ///< the same along the equator
  double cell_radians() const { return cell_radians_; }  ///< the sample spacing in longitude and latitude

  /// Geocentric positions of the tile's samples.
  const GridPositions& positions() const { return positions_; }

  std::uint64_t bytes() const;

 private:
  /// A sphere relative to the middle of the tile, where single precision is enough.
  struct LocalSphere {
    glm::vec3 centre;
    float radius_m;
  };

  std::size_t slot(int k, int x, int y) const {
    return first_[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (levels_ - k)) +
           static_cast<std::size_t>(x);
  }
  void fill(const HeightTile& heights, const std::vector<float>& errors_m);
  std::vector<std::array<double, 2>> height_ranges_m(const HeightTile& heights, double quantum_m) const;
  void measure_sagittas(const std::vector<std::array<double, 2>>& ranges, double highest_m,
                        const Ellipsoid& ellipsoid);
  void place_spheres(const HeightTile& heights, const std::vector<std::array<double, 2>>& ranges);
  SquareSphere sphere_over(int k, int x, int y, double low_m, double high_m) const;
  LocalSphere local_sphere(const SquareSphere& sphere) const;

  GridPositions positions_;
  int levels_;
  double cell_radians_;
  double cell_m_;
  std::array<double, 16> sagittas_m_{};
  std::array<std::size_t, 16> first_{};
  std::vector<SquareError> squares_;
  glm::dvec3 middle_{0};
  std::vector<LocalSphere> spheres_;  ///< by slot, larger squares first
};

}  // namespace cairn
