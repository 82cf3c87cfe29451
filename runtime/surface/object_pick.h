#pragma once

#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "cairn/body.h"
#include "cairn/surface.h"
#include "runtime/surface/surface_plan.h"

namespace cairn {

/// Returns the nearest object whose model a ray meets, in its finest level.
std::optional<ObjectHit> pick_object(std::span<const ObjectPatch> patches, const Ellipsoid& ellipsoid,
                                     const glm::dvec3& origin, const glm::dvec3& direction);

}  // namespace cairn
