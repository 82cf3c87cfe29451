#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "cairn/loaded_objects.h"
#include "cairn/surface_objects.h"
#include "cairn/view_state.h"
#include "runtime/surface/surface_plan.h"

namespace cairn {

/// How the objects of a frame are drawn.
struct ObjectRules {
  ViewState view;
  double error_px = 0.5;   ///< that a level of a model may be off its finest
  double smallest_px = 1;  ///< objects of this size and below are not drawn
};

/// How much of the objects is drawn that have come into memory: none at first, and all after half a second.
class ObjectArrivals {
 public:
  /// Takes the tiles of a frame. Those of the first frame, and of the first after cut(), are drawn at once.
  void update(std::span<const std::shared_ptr<const LoadedObjects>> tiles, double frame_s);
  /// 1 for tiles of which update() does not know.
  float share_of(const LoadedObjects& tile) const;
  void cut() { shares_.clear(); }

 private:
  std::unordered_map<const LoadedObjects*, float> shares_;
};

/// Chooses what is drawn of each object: nothing outside the picture, the coarsest level that is not off by
/// more than allowed, or the billboard, where that has a texel for each pixel. Between a level and a
/// billboard both are drawn in part, and towards the smallest size less and less of the billboard.
SurfaceObjects object_instances(std::span<const ObjectPatch> patches, const ObjectArrivals& arrivals,
                                const ObjectRules& rules);

}  // namespace cairn
