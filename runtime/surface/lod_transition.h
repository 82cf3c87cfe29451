#pragma once

#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/render_list.h"
#include "runtime/surface/surface_tile.h"

namespace cairn {

/// A tile of a frame and the detail that the frame shows of its heights.
struct ShownTile {
  RenderTile tile;
  double detail = 0;   ///< see ShownSurface
  double wanted = 0;   ///< what the detail is on its way to
  bool moves = false;  ///< the detail changed in this frame, or is about to
};

/// What the speed of an exchange follows from.
struct FrameScale {
  glm::dvec3 eye{};  ///< geocentric, metres
  double pixels_per_radian = 1000;
  double tolerance_px = 1;
  double longest_fade = 120;  ///< frames that a level takes at most
};

/// What frames show of the render lists: tiles are exchanged for their successors smoothly.
///
/// A finer tile begins as the coarser one that it replaces and gains detail from frame to frame; a tile that
/// a coarser one replaces loses its detail first. As samples nest, the tile itself has both shapes and all
/// between. In a frame no place of it moves by more than half the tolerance, seen from the eye, so that with
/// what MeshRules leaves to the grids no place moves by more than the tolerance. But a level takes
/// longest_fade frames at most: what comes so late, or so near the eye, that this is too few glides at that
/// speed. (An eye inside a tile's volume is at no distance that is known.)
///
/// A tile that was not visible in the last frame is shown with all its detail at once.
class LodTransition {
 public:
  /// The prepared heights of a visible tile; null where it has none.
  using SurfaceOf = std::function<const SurfaceTile*(const RenderTile& tile)>;

  /// Call once a frame. What it returns covers the Earth, and holds until the next call.
  std::span<const ShownTile> update(const RenderList& list, const FrameScale& scale,
                                    const SurfaceOf& surface_of);
  std::span<const ShownTile> tiles() const { return shown_; }

  /// The next frame has nothing to do with the last one: a cut in a film.
  void cut() { shown_.clear(); }

 private:
  void move(const FrameScale& scale, const SurfaceOf& surface_of);
  void follow(const RenderList& list, const glm::dvec3& eye);

  std::vector<ShownTile> shown_;  // depth first, as a cover
};

}  // namespace cairn
