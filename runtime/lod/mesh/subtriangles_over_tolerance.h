#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "runtime/lod/mesh/subtriangle_error_ranges.h"

namespace cairn {

/// A flat triangle D between samples, in a camera (right, up, along the view), and what is known of the
/// surface under it. With h the heights that are linear between the corners', S(h) is the curved surface that
/// has them.
struct FlatTriangle {
  std::array<glm::dvec3, 3> corners;  ///< the base's two, then the right angle
  std::array<glm::dvec3, 3> ups;      ///< unit vectors out of the ellipsoid at these
  /// D − S(h) there: 0 but where this is a part of a flat triangle.
  std::array<glm::dvec3, 3> bulges{glm::dvec3{0}, glm::dvec3{0}, glm::dvec3{0}};
  std::array<glm::dvec3, 3> middle_bulges;  ///< D − S(h) at the middles of the base, of leg q and of leg p
  double slack_m = 0;  ///< the places that subtriangles_over_tolerance() derives are no farther off, in all
};

/// What is quadratic of its bulges, at the middles of the base, of q and of p.
std::array<glm::dvec3, 3> bends_of(const FlatTriangle& triangle);

/// A picture, at depth 1.
struct SubtriangleViewport {
  double half_width;
  double half_height;
  double nearest_m;  ///< what is nearer along the view is off
  bool has_all;      ///< of the triangle
};

/// The parts, bit by number, of which some place may be in the picture and off by more than the tolerance
/// there; of the others none is. `beyond_m`: the surface is so far beyond the ranges at most, vertically.
///
/// At any place, with e of the part's range, D − P = Q + e·up, Q = D − S(h); a place is off by
/// |(D−P)⊥ − t(D−P)z| / Pz, t = D⊥/Dz. Q is quadratic in the legs, to third order, and so known from three
/// places. Over a part D is linear, Q and up nearly so, and t is a mean of the corners'. So where t differs
/// by ω within a part, Σwᵢ the weights of its corners, e at an end of its range,
///   |(D−P)⊥ − t(D−P)z| <= max |dᵢ⊥ − tᵢdᵢz| + ω max |dᵢz| + slack·√(1+|t|²),   dᵢ = Qᵢ + e·upᵢ,
///   Pz >= min (Dᵢz − dᵢz) − slack.
std::uint32_t subtriangles_over_tolerance(const FlatTriangle& triangle,
                                          const SubtriangleErrorRanges::Ranges& ranges,
                                          const SubtriangleViewport& picture, double tolerance,
                                          double beyond_m);

}  // namespace cairn
