#pragma once

// START HERE to let cairn draw a pack into your OpenGL program.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "cairn/drape.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "cairn/terrain.h"
#include "cairn/tint.h"
#include "cairn/view_state.h"

namespace cairn {

/// How the ground looks.
struct GlLook {
  glm::dvec3 to_sun{0, 0, 1};  ///< geocentric, unit length
  bool sky = true;             ///< drawn where the depth is still the farthest; with a perspective only
  bool fog = true;
  /// Air, and water at 0 m and below; else a black sky and grey ground. False of a pack of another body.
  bool is_earth = true;
  /// Ground casts shadows, which are made on threads, tile by tile, when a tile is first shown and when the
  /// sun has moved. Until then a tile has none; GlCounts says how many.
  bool shadows = false;
  bool objects = true;      ///< what stands on the ground is drawn too
  bool depth_only = false;  ///< no colour is written, and no sky
  bool wireframe = false;
  bool dithers = false;  ///< noise of a step of 8 bits, so that the sky shows no bands
  /// Ground at this height and below lies under water, metres in the pack's vertical datum: all of it, also
  /// dry land, for a pack says of no place whether it is sea. From below the surface nothing of it is seen.
  /// The Earth only.
  std::optional<double> sea_m;
  double contours_m = 0;       ///< between lines of equal height, each fifth a strong one; 0: none
  bool slope_colours = false;  ///< from 25° on a colour for each 5°
  bool level_colours = false;  ///< a colour for each level of the tiles instead of imagery or tint
  /// Colours of heights, ascending, kMostTintStops at most. Empty: tints()[0] of the Earth, else greys.
  std::vector<TintStop> tint;
  double imagery = 1;                  ///< the share of imagery, 0 to 1, over the tint
  double exposure_ev = 0;              ///< each step doubles the light of the whole picture
  std::shared_ptr<const Drape> drape;  ///< lines and points on the ground; never changed once it is here
};

/// Where a picture goes, without a clear: what nearer things have drawn there hides the ground.
struct GlTarget {
  unsigned framebuffer = 0;  ///< the name; one with several samples a pixel too
  int x = 0;                 ///< of the viewport's lower left corner, pixels
  int y = 0;
  int width_px = 0;
  int height_px = 0;
  bool reversed_depth = true;  ///< depth 1 near and 0 far, cleared to 0, in a float buffer; else OpenGL's own
  bool is_srgb = true;         ///< the colour attachment encodes what is written; else it is written linear
};

/// What a picture took.
struct GlCounts {
  std::size_t patches = 0;
  std::size_t triangles = 0;
  std::size_t shadows_due = 0;   ///< tiles that show no shadow yet, or that of an earlier sun
  std::uint64_t gpu_bytes = 0;   ///< of textures and buffers
  std::optional<double> gpu_ms;  ///< of an earlier picture, the last that the GPU has finished; by its clock
  std::size_t objects = 0;       ///< in the picture
  std::size_t billboards = 0;    ///< of these, drawn as billboards
  std::size_t object_calls = 0;  ///< draw calls: one for each model and level, or billboard
  std::size_t object_triangles = 0;  ///< not in `triangles`
};

/// From metres relative to the eye, along the body's axes, to clip space; depth is 5 cm / distance: 1 at the
/// near plane, 0 infinitely far. What GlTerrain::draw() takes where it is given no other.
glm::dmat4 clip_from_eye(const ViewState& view);

/// The terrain of a pack in an OpenGL 4.5 context.
///
/// All is called with that context current, on its thread. The host's state is neither trusted nor changed:
/// what drawing depends on is set, and what was there is given back, but a transform feedback, conditional
/// rendering or a pipeline statistics query in progress. docs/using-the-runtime.md has a program.
class GlTerrain {
 public:
  /// failed where the context is older than 4.5 or a shader is refused; what Terrain::open() fails with.
  static Result<GlTerrain> create(std::shared_ptr<const PackReader> pack, const TerrainOptions& options = {});
  GlTerrain(GlTerrain&&) noexcept;
  GlTerrain& operator=(GlTerrain&&) noexcept;
  ~GlTerrain();

  /// Call once a frame: pages tiles, makes the surface for the view, with `tolerance_px` of screen error,
  /// tiles and mesh together (TerrainOptions::tolerance_px is not used), and uploads what is new. The list
  /// holds until the next call.
  const RenderList& update(const ViewState& view, double dt_s, double tolerance_px = 1);

  /// The next update has nothing to do with the last one: nothing glides into it.
  void cut();

  /// Draws the surface of the last update, as often as wanted. A projection of one's own, off-centre,
  /// jittered or orthographic, sees ground where it sees nothing that the view does not; its depth is as
  /// the target says.
  GlCounts draw(const GlLook& look, const GlTarget& target);
  GlCounts draw(const GlLook& look, const GlTarget& target, const glm::dmat4& clip_from_eye);

  const Terrain& terrain() const;

  /// What this context cannot show, each once, since the last call.
  std::vector<Error> take_errors();

 private:
  struct State;
  explicit GlTerrain(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
