#pragma once

#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/loaded_objects.h"
#include "runtime/surface/surface_patch.h"

namespace cairn {

/// Where an object stands: on the triangle that is drawn under it.
///
/// The place is the mean of the triangle's vertices, weighted as the object lies between them, so that it
/// is on the flat triangle and not on the curved ellipsoid that this stands for. While tiles are exchanged
/// the foot glides with the ground, as the triangle's vertices do: it is drawn at
/// place + SurfaceDraw::coarser_share · to_coarser.
struct ObjectFoot {
  glm::dvec3 place{0};  ///< geocentric, metres
  glm::vec3 to_coarser{0};
  glm::vec2 heading{0, 1};  ///< its sine and cosine
};

/// Where an object lies, in units of the lattice from 180°W and 90°S.
struct ObjectPlace {
  double x = 0;
  double y = 0;
};
ObjectPlace place_on_lattice(const TileId& tile, const PlacedObject& object);

/// Returns the feet of a tile's objects that lie in a patch, in their order. An object beside the patch has
/// the foot of the nearest place inside.
std::vector<ObjectFoot> object_feet(const SurfacePatch& patch, const SideVertices& sides, double quantum_m,
                                    const TileId& tile, std::span<const StandingObject> objects);

/// A sphere around the feet of some objects, and the size of the largest.
struct ObjectCluster {
  glm::dvec3 middle{0};  ///< geocentric, metres
  float radius_m = 0;    ///< also while the feet glide
  float largest_m = 0;
};
ObjectCluster cluster_of(std::span<const StandingObject> objects, std::span<const ObjectFoot> feet);

}  // namespace cairn
