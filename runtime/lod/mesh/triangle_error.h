#pragma once

#include <array>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/sample_rows.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/subtriangle_error_ranges.h"
#include "runtime/view/horizon.h"
#include "cairn/view_state.h"

namespace cairn {

/// What a flat triangle between samples of a tile is off by on the picture: the measure of Screen, where a
/// bound from afar (ScreenErrorBudget) is too careful.
///
/// A bound over the whole triangle comes first. With P the finest surface, D the triangle,
///   D − P = ρ = v·up + c,
/// |v| at most the triangle's vertical error and the tile's, |c| at most its chord (SquareErrors). With
/// t = P⊥/Pz along the ray to P, the picture of the place moves by f|(D − P)⊥ − t(D − P)z| / Dz: exactly.
/// Where t differs by ω at most, up by α, and √(1+|t|²) <= s, the move is within the tolerance τ if
///   |v|·min(s, |up⊥ − t·upz| + ω|upz| + αs) + |c|s <= τ/f · min Dz,
/// up and t here those at the right angle, Dz at the corners. The triangle is seen within that of its
/// corners' pictures, P |ρ|s/Pz from there at most: ω is that triangle's diameter and this. Otherwise a small
/// triangle's samples are projected, all at once, and a larger one is held against the tolerance in parts
/// (subtriangles_over_tolerance).
class TriangleError {
 public:
  /// `lowest_m`: of the scene; what the ellipsoid there hides is not in the picture.
  TriangleError(const LodView& view, double lowest_m);

  struct Surface {
    const HeightTile& heights;
    double quantum_m;
    const SquareErrors& errors;
    const SubtriangleErrorRanges& ranges;
    double error_m;  ///< the finest samples are no farther from the heights' bilinear surface, vertically
  };
  /// (column, row) of the tile's samples.
  using Corner = std::array<int, 2>;

  /// No only if every sample that the triangle covers, its edges included, and that is in the picture is
  /// within the tolerance of its place on it, the triangle in front of the eye there; where the surface has
  /// an error of its own, every place between the samples too. Where that error alone takes more than three
  /// quarters of the tolerance, a quarter is allowed all the same. May say yes where it is not so: what takes
  /// too long to find out. REQUIRES: anticlockwise corners, the right angle last.
  bool exceeds(const Surface& surface, const std::array<Corner, 3>& triangle) const;

 private:
  class Look;

  CameraFrame camera_;
  SampleCamera sample_camera_;
  Horizon horizon_;
  double tolerance_;  ///< here and below at depth 1
  double half_width_;
  double half_height_;
};

}  // namespace cairn
