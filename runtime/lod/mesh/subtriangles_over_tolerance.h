#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "runtime/lod/mesh/subtriangle_error_ranges.h"

namespace cairn {

/// A flat triangle D between samples, in camera coordinates (right, up, along the view), in metres.
///
/// Let h be the height that is linear between the corners' heights. S(h) is the curved surface with these
/// heights, and D − S(h) is the triangle's bulge, which the Earth's curvature makes.
struct FlatTriangle {
  std::array<glm::dvec3, 3> corners;  ///< the two of the base, then the right angle
  std::array<glm::dvec3, 3> ups;      ///< the ellipsoid's unit normals there
  /// The bulge at the corners. It is 0 unless this is a piece of a larger flat triangle.
  std::array<glm::dvec3, 3> bulges{glm::dvec3{0}, glm::dvec3{0}, glm::dvec3{0}};
  std::array<glm::dvec3, 3> middle_bulges;  ///< the bulge at the middles of the base, of leg q and of leg p
  double slack_m = 0;                       ///< bound of the errors of what is derived from these
};

/// Returns the second-order part of the bulge at the middles of the base, of leg q and of leg p.
std::array<glm::dvec3, 3> quadratic_bulges(const FlatTriangle& triangle);

/// The viewport at depth 1, in multiples of the depth.
struct SubtriangleViewport {
  double half_width;
  double half_height;
  double nearest_m;        ///< what has a smaller depth exceeds the tolerance
  bool contains_triangle;  ///< no part of the triangle is outside
};

/// Returns the parts, bit by number, that may exceed the tolerance at a place in the viewport. No other does.
///
/// `tolerance` is at depth 1, as the viewport. `beyond_m` is how far, at most, the surface lies outside the
/// ranges, vertically. May return more parts than exceed the tolerance, never fewer.
///
/// At any place, with e from the part's range, D − P = Q + e·up, where Q = D − S(h). The place is displaced
/// by
/// |(D−P)⊥ − t(D−P)z| / Pz, where t = D⊥/Dz. Q is quadratic along the legs, to third order, so three places
/// determine it. Over a part D is linear, Q and up nearly so, and t is a mean of the corners' values. So
/// where t differs by at most ω within a part and e is an end of its range,
///   |(D−P)⊥ − t(D−P)z| <= max |dᵢ⊥ − tᵢdᵢz| + ω max |dᵢz| + slack·√(1+|t|²),   dᵢ = Qᵢ + e·upᵢ,
///   Pz >= min (Dᵢz − dᵢz) − slack.
std::uint32_t subtriangles_over_tolerance(const FlatTriangle& triangle,
                                          const SubtriangleErrorRanges::Ranges& ranges,
                                          const SubtriangleViewport& viewport, double tolerance,
                                          double beyond_m);

}  // namespace cairn
