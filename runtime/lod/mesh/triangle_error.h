#pragma once

#include "runtime/lod/mesh/triangle_samples.h"

namespace cairn {

/// Tests whether flat triangles between samples of a tile exceed a tolerance on the screen, by Screen's
/// measure.
///
/// ScreenErrorBudget bounds whole squares from afar and is often too careful. Here a bound over the triangle
/// comes first (TriangleBound); then the samples of a small triangle are projected one by one, and a larger
/// triangle is tested in parts (any_part_exceeds()). Immutable; any thread may use it.
class TriangleError {
 public:
  /// `lowest_m` is the lowest height of the scene. What the ellipsoid at that height occludes is invisible.
  TriangleError(const LodView& view, double lowest_m) : view_(view, lowest_m) {}

  /// Returns false only if every visible sample under the triangle, its edges included, is within the
  /// tolerance and the triangle is in front of the camera there. May return true although it is, which costs
  /// triangles, never accuracy.
  ///
  /// Where the surface has an error of its own, places between samples count too; where that error takes more
  /// than three quarters of the tolerance, a quarter is allowed nevertheless. REQUIRES: a triangle of the
  /// tile's bisection hierarchy, anticlockwise, the right angle last.
  bool exceeds(const TileSurface& surface, const SampleTriangle& triangle) const;

 private:
  TriangleView view_;
};

}  // namespace cairn
