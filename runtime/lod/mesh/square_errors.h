#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// A length in metres as the upper half of a float, rounded up: 0.4 % too large at most. Ordered like the
/// lengths; 0 only of 0.
std::uint16_t round_up(float length_m);
/// Of such a code.
inline float length_m(std::uint16_t code) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(code) << 15);
}
/// The largest code whose lengths are all at most this; -1 for a negative length.
int round_down(float length_m);

/// Of a square of a tile's hierarchy: how far samples are, at most, from the triangles that are bisected at
/// its centre and at the middles of its edges (south, east, north, west), rounded up.
struct SquareError {
  std::uint16_t below = 0;  ///< the largest of these and of all squares within
  std::uint16_t centre = 0;
  std::array<std::uint16_t, 4> middles{};
};

/// A sphere around all of the surface over a square.
struct SquareSphere {
  glm::dvec3 centre{0};
  double radius_m = 0;
};

/// What is known of a tile when it is loaded, for bisecting its squares where a picture asks for it.
///
/// The errors are those of vertex_errors_m(), without the Earth's curvature: see chord_m().
class SquareErrors {
 public:
  /// Squares with spheres have at least this many cells.
  static constexpr int kSphereLevel = 2;

  SquareErrors(const LodScene& scene, const LodTile& tile, bool between_samples);

  int levels() const { return levels_; }  ///< log2 of the tile's cells
  const SquareError& at(int k, int x, int y) const { return squares_[slot(k, x, y)]; }
  /// Of the square, or of the smallest one around it that has one.
  SquareSphere sphere(int k, int x, int y) const;

  /// How far a flat triangle bisected at the centre of a square of 2^k cells is from the curved Earth, at
  /// most, at the height that it has there; half of it where it is bisected at a middle. That of a level
  /// surface, chord_of_cell_m(), and of its lean: where the corners' heights hᵢ differ, so do their normals
  /// nᵢ, by which Σ wᵢwⱼ(hᵢ − hⱼ)(nᵢ − nⱼ) over the three pairs is added, 0.39 times the longer leg (in
  /// radians) and what the heights differ by, at most.
  double chord_m(int k) const { return chords_m_[static_cast<std::size_t>(k)]; }

  double cell_radians() const { return cell_radians_; }  ///< of longitude and of latitude

  /// Of the tile's samples.
  const GridPositions& positions() const { return positions_; }

  std::uint64_t bytes() const;

 private:
  /// From the middle of the tile: single precision is enough.
  struct NearSphere {
    glm::vec3 centre;
    float radius_m;
  };

  std::size_t slot(int k, int x, int y) const {
    return first_[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (levels_ - k)) +
           static_cast<std::size_t>(x);
  }
  void fill(const HeightTile& heights, const std::vector<float>& errors_m);
  std::vector<std::array<double, 2>> ranges_m(const HeightTile& heights, double quantum_m) const;
  void measure_chords(const std::vector<std::array<double, 2>>& ranges, double highest_m);
  void place_spheres(const HeightTile& heights, const std::vector<std::array<double, 2>>& ranges);
  SquareSphere sphere_over(int k, int x, int y, double low_m, double high_m) const;
  NearSphere near_sphere(const SquareSphere& sphere) const;

  GridPositions positions_;
  int levels_;
  double cell_radians_;
  std::array<double, 16> chords_m_{};
  std::array<std::size_t, 16> first_{};
  std::vector<SquareError> squares_;
  glm::dvec3 middle_{0};
  std::vector<NearSphere> spheres_;  ///< by slot: the larger squares come first
};

}  // namespace cairn
