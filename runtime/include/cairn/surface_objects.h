#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/object_model.h"

namespace cairn {

/// One object of a frame, as a buffer of instances takes it.
///
/// A vertex of the model at (x, y, z) is drawn at from_eye + scale · (e·x + n·y + up·z), where e and n are
/// east and north turned clockwise by the heading, and up is the ellipsoid's normal at the foot.
struct ObjectInstance {
  glm::vec3 from_eye{0};  ///< of the foot, metres, along the body's axes: on the ground that the frame draws
  float scale = 1;
  glm::vec2 heading{0, 1};  ///< its sine and cosine
  /// Pixels are drawn where a pattern of the screen, evenly spread over 0…1, has a value from shown.x up to
  /// but not including shown.y: an object that comes, goes or changes to its billboard is drawn in part.
  glm::vec2 shown{0, 1};
};
static_assert(sizeof(ObjectInstance) == 32);

/// Instances that are drawn by one call.
struct ObjectDraw {
  std::shared_ptr<const ObjectModel> model;
  int level = 0;  ///< of ObjectModel::levels; kBillboard: the billboard
  std::uint32_t first = 0;
  std::uint32_t count = 0;

  static constexpr int kBillboard = -1;
};

/// The objects of one frame: one draw for each model and level, and all that they draw.
struct SurfaceObjects {
  std::vector<ObjectInstance> instances;
  std::vector<ObjectDraw> draws;
  std::size_t objects = 0;     ///< in the picture; one on its way to its billboard is two instances
  std::size_t billboards = 0;  ///< of these, the ones that show it
  std::uint64_t triangles = 0;
};

}  // namespace cairn
