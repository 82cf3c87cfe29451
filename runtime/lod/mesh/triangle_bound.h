#pragma once

#include "runtime/lod/mesh/triangle_samples.h"

namespace cairn {

/// Bounds what a whole flat triangle D is displaced by on the screen, from its stored error alone.
///
/// With P the finest surface, D − P = ρ = v·up + c, where |v| is at most the triangle's vertical error plus
/// the tile's, and |c| is at most the sagitta. With t = P⊥/Pz along the ray to P, the projection of the place
/// moves by exactly f|(D − P)⊥ − t(D − P)z| / Dz pixels. Where t differs by at most ω over the triangle, up
/// by at most α, and √(1+|t|²) <= s, the move is within the tolerance τ if
///   |v|·min(s, |up⊥ − t·upz| + ω|upz| + αs) + |c|s <= τ/f · min Dz,
/// with up and t at the right angle, Dz at the corners. The triangle's places are seen within |ρ|s/Pz of the
/// triangle of its projected corners: ω is that triangle's diameter plus this distance.
class TriangleBound {
 public:
  /// REQUIRES: the arguments outlive this.
  TriangleBound(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples);

  /// Returns true only if no visible place exceeds the tolerance.
  bool is_within() const;
  /// Returns true only if no place of the triangle is both in the viewport and above the horizon.
  bool is_invisible() const;
  /// Returns whether an exact test would hardly ever find the triangle within the tolerance. It is a guess:
  /// true where some sample exceeds wherever in the triangle it lies (if it is not the sample of the other
  /// triangle at this base), and where the bound is far above the tolerance.
  bool assume_exceeds() const;

 private:
  double reach_m() const;  ///< |ρ| at most

  const TriangleView& view_;
  const TileSurface& surface_;
  const CornerSamples& samples_;
  double turn_;     ///< ω of the triangle's own places
  double slant_;    ///< s
  double up_;       ///< |up⊥ − t·upz| at the right angle
  double up_z_;     ///< |upz| there
  double up_turn_;  ///< α
};

/// Radians of a leg, up to which the curvature's bound is close. Larger triangles are tested in quarters.
constexpr double kMaxCurvatureLeg = 0.1;

}  // namespace cairn
