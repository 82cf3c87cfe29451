#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "cairn/surface.h"
#include "cairn/terrain.h"
#include "runtime/flight/camera_text.h"
#include "runtime/gl/frame_target.h"
#include "runtime/gl/renderer.h"
#include "runtime/lod/lod_method.h"
#include "runtime/viewer/object_editor.h"
#include "runtime/viewer/options.h"

namespace cairn::viewer {

/// How a frame looks and is made.
struct FrameLook : GlLook {
  std::optional<glm::vec3> hole_colour;   ///< linear RGB: drawn where no terrain is, instead of the sky
  double frame_s = 1.0 / 60;              ///< since the last frame: the exchange of levels follows the clock
  double tolerance_px = 1;                ///< screen error of mesh and tiles together; > 0
  double object_px = 2;                   ///< objects that are not larger are not drawn; > 0
  const LodMethodInfo* method = nullptr;  ///< draws a method's mesh instead of the surface: on one thread,
                                          ///< tiles exchanged at once, so for comparing pictures
  bool waits_for_shadows = false;         ///< draws when all shadows are there
  bool draws = true;                      ///< false: all of a frame's work but the draw calls, to measure it
};

/// What a frame took.
struct FrameCounts : GlCounts {
  std::size_t uploads = 0;  ///< tiles that became textures
  double upload_ms = 0;     ///< CPU time of the thread that this took
};

/// A pack, its terrain and its renderer: what a window and a picture have in common. One context is current
/// for as long as it lives.
class Scene {
 public:
  static Result<Scene> open(const Options& options);

  /// The two halves of a frame: what is to be drawn, and drawing it.
  void update(const ViewState& view, double dt_s);
  FrameCounts draw_list(const ViewState& view, const FrameLook& look, unsigned framebuffer);

  /// One frame into the framebuffer.
  FrameCounts draw(const ViewState& view, double dt_s, const FrameLook& look, unsigned framebuffer);

  /// Draws no frame, but lets the terrain load until the view has all that the pack has for it and that can
  /// be read.
  void load_all(const ViewState& view);
  /// Sets the screen error for which tiles are loaded, as FrameLook::tolerance_px does in draw().
  void set_tolerance_px(double tolerance_px) { terrain_.set_tolerance_px(tolerance_px); }

  /// The next frame has nothing to do with the last one: what it shows is not on its way from there.
  void cut() { surface_.cut(); }

  /// The ground, in metres, that is drawn or will be when tiles have been exchanged, whichever is higher; 0
  /// where nothing is. After the first update.
  double ground_m(LonLat place) const;

  /// The nearest object of the last frame that a ray meets, as Surface::pick().
  std::optional<ObjectHit> pick(const glm::dvec3& origin, const glm::dvec3& direction) const {
    return surface_.pick(origin, direction);
  }
  /// The objects of the last frame.
  const SurfaceObjects& objects() const { return frame_->objects; }

  /// Of a local pack with models; else null.
  ObjectEditor* editor() { return editor_ ? &*editor_ : nullptr; }

  const PackReader& pack() const { return *pack_; }
  std::shared_ptr<const PackReader> shared_pack() const { return pack_; }
  const Terrain& terrain() const { return terrain_; }
  const RenderList* list() const { return list_; }

  /// What went wrong since the last call, each thing once.
  std::vector<Error> take_errors();

 private:
  Scene(std::shared_ptr<const PackReader> pack, Surface surface, Terrain terrain, gl::Renderer renderer);
  SurfaceMesh method_mesh(const SurfaceFrame& frame, const ViewState& view, const FrameLook& look);

  std::shared_ptr<const PackReader> pack_;
  Surface surface_;
  Terrain terrain_;
  gl::Renderer renderer_;
  std::unique_ptr<SunShadows> shadows_;  // from the first frame that has any
  const RenderList* list_ = nullptr;
  const SurfaceFrame* frame_ = nullptr;         // the last one
  const LodMethodInfo* method_info_ = nullptr;  // of the method, which is kept from frame to frame
  std::unique_ptr<LodMethod> method_;
  std::optional<ObjectEditor> editor_;
  std::vector<Error> errors_;
};

/// Returns the direction to the sun, geocentric, at an hour of local solar time at the place, 0…24. The day
/// is the one on which the sun stands highest there: the summer solstice outside the tropics, inside them the
/// day on which it passes the zenith.
glm::dvec3 sun_direction(LonLat place, double hour);

/// Where the sun stands.
struct SunTime {
  double hour = 10;             ///< as sun_direction() takes it
  std::optional<double> utc_s;  ///< since 1970, UTC: counts instead of the hour
};
glm::dvec3 sun_direction(LonLat place, const SunTime& time);
Result<SunTime> sun_time_of(const Options& options, const PackReader& pack);

/// The lowest and the highest ground of a pack, metres; 0 and 0 where it has none.
struct HeightRange {
  double lowest_m = 0;
  double highest_m = 0;
};
HeightRange height_range(const PackReader& pack);

/// The view that the pack's bounds fill.
ViewState start_view(const PackReader& pack, double fov_deg, Size size);

/// The view that --camera asks for, else start_view().
Result<ViewState> view_of(const Options& options, const PackReader& pack, Size size);

/// The frame's look that the options ask for, apart from the sun.
Result<FrameLook> look_of(const Options& options, const PackReader& pack);

}  // namespace cairn::viewer
