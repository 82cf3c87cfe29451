#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "cairn/view_state.h"

namespace cairn::gl {

/// Anything nearer is not drawn. With a reversed float depth it may be as near as one likes.
inline constexpr double kNear_m = 0.05;

/// From metres relative to the eye, along the body's axes, to clip space; depth is near / distance: 1 at the
/// near plane, 0 infinitely far.
glm::dmat4 clip_from_eye(const CameraFrame& camera, const ViewState& view);

/// A plane, for positions relative to the eye, that all the ground before the horizon lies inside of, and
/// most of the body's far side outside: a hole in the ground must not show the inside of the antipodes.
///
/// Scaled so that an ellipsoid below all ground is the unit sphere, the eye at distance m > 1 sees the sphere
/// up to the plane 1/m along its own direction; ground of radius r behind the sphere's horizon up to 1/m -
/// sqrt(1 - 1/m²)·sqrt(r² - 1).
glm::dvec4 horizon_plane(const glm::dvec3& eye, const Ellipsoid& ellipsoid);

}  // namespace cairn::gl
