#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/view_state.h"
#include "runtime/gl/frame_target.h"
#include "runtime/gl/headless_context.h"
#include "runtime/gl/view_transform.h"
#include "runtime/viewer/scene.h"

namespace cairn::test {

/// A pack drawn without a display, through the whole pipeline; Mesa's llvmpipe is enough. Where no terrain is
/// the picture is magenta.
class Stage {
 public:
  explicit Stage(const std::filesystem::path& pack, int width = 160, int height = 120);

  /// One frame, when all that the pack has for the view is loaded.
  void draw(const ViewState& view);
  /// One frame of what is loaded by now.
  void draw_now(const ViewState& view, double dt_s);

  viewer::Scene& scene() { return *scene_; }
  const gl::FrameTarget& target() const { return *target_; }
  /// The ground as the last frame drew it, in metres; 0 where nothing is.
  double ground_m(LonLat place) const { return scene_->list() ? scene_->ground_m(place) : 0; }
  /// Magenta pixels of the last frame.
  int holes() const;

  viewer::FrameLook look;

 private:
  Result<gl::HeadlessContext> context_;  // before all that lives in it
  Result<gl::FrameTarget> target_;
  std::optional<viewer::Scene> scene_;
};

/// A view of 45° through a picture of 160×120.
ViewState view_at(LonLat eye, double height_m, double heading_deg, double pitch_deg);

/// The direction at an azimuth and a height above the horizon of a place, degrees.
glm::dvec3 sun_at(LonLat place, double azimuth_deg, double height_deg);

/// Where a picture shows a geocentric point, in pixels: pixel (i, j) reaches from (i, j) to (i+1, j+1), rows
/// down.
struct PicturePoint {
  double x = 0;
  double y = 0;
  double depth_m = 0;  ///< along the view
};
PicturePoint project(const ViewState& view, const glm::dvec3& point);

/// The geocentric point that a picture shows at (x, y), from what FrameTarget::read_depth() has there.
glm::dvec3 shown_at(const ViewState& view, double x, double y, double depth);

}  // namespace cairn::test
