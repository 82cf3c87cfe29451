#pragma once

#include <array>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "cairn/body.h"
#include "cairn/geo.h"

namespace cairn {

/// The position, direction and viewport of a camera.
///
/// Every height of the runtime is in the vertical datum of the pack (PackHeader::vertical_datum), the eye's
/// included, so that the height of the ground plus a clearance is a height of the eye. The scene is laid out
/// as if that datum were the ellipsoid. VerticalConversion converts heights above the ellipsoid.
struct ViewState {
  LonLat eye;                    ///< any longitude; latitude within ±90
  double height_m = 0;           ///< in the pack's vertical datum
  double heading_deg = 0;        ///< clockwise from north
  double pitch_deg = 0;          ///< up from the horizontal; -90 looks straight down
  double roll_deg = 0;           ///< clockwise along the view
  double fov_y_deg = 60;         ///< between the top and the bottom of the viewport; 0 < fov < 180
  int viewport_width_px = 1920;  ///< > 0
  int viewport_height_px = 1080;
  /// Of the body that the eye is at; Terrain and Surface take that of their pack instead.
  Ellipsoid ellipsoid = {};
};

/// A camera's position in geocentric metres, and its unit axes; the view is along `forward`.
struct CameraFrame {
  glm::dvec3 position;
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;

  /// Returns metres to the right, up, and along the view.
  glm::dvec3 in_camera(const glm::dvec3& point) const {
    const glm::dvec3 to = point - position;
    return {glm::dot(to, right), glm::dot(to, up), glm::dot(to, forward)};
  }
};
CameraFrame camera_frame(const ViewState& view);

/// Returns unit normals, pointing inwards, of the planes through the camera and the viewport's four sides,
/// and of the plane that separates the front from the back.
std::array<glm::dvec3, 5> inward_normals(const CameraFrame& camera, const ViewState& view);

/// Returns the width, in metres, of a pixel on a plane at this distance perpendicular to the view:
/// 2·d·tan(fov/2)/height.
double pixel_footprint_m(const ViewState& view, double distance_m);

}  // namespace cairn
