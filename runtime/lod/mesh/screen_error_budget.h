#pragma once

#include <algorithm>
#include <array>

#include <glm/vec3.hpp>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/view/horizon.h"

namespace cairn {

/// What triangles may be off by, as one eye sees them.
///
/// A displacement δ of a point at depth z, with P the ray from the eye to it, moves its picture by
/// f|z·δ⊥ − P⊥·δz| / (z(z−δz)) pixels, ⊥ what is across the view: exactly, not to first order; that is
/// f|P||δ| / (z(z−|δ|)) at most. So with e the error of a triangle, g that of its tile, both vertical, and c
/// the chord of the Earth's curvature in any direction, the picture moves by
/// f((e+g)|z·up⊥ − P⊥·upz| + c|P|) / (z(z−e−g−c)) pixels at most. (|P×up| for the first length would do, but
/// is longer by the view's own direction's part of it: 1.4 times at the sides of a wide picture.)
class ScreenErrorBudget {
 public:
  /// `lowest_m`: of the scene; what the ellipsoid there hides is not in the picture.
  ScreenErrorBudget(const LodView& view, double lowest_m);

  double tolerance_px() const { return tolerance_px_; }

  /// How displacements become pixels over some part of the picture: δ by px·δ/(depth − δ) at most.
  struct Scale {
    double depth_m = 0;      ///< along the view, or less; 0 or below: it may come beside the eye
    double vertical_px = 0;  ///< of a vertical displacement
    double any_px = 0;       ///< of one in any direction
    bool is_small = false;   ///< this hardly changes over the part
  };
  /// Of what is in the picture of a sphere; `up` is the ellipsoid's normal at its middle.
  Scale scale_of(const SquareSphere& sphere, const glm::dvec3& up) const;
  Scale scale_of(const SquareSphere& sphere) const;
  /// Of what is in the picture and at least this far away.
  Scale scale_from(double distance_m) const;

  /// The same without what is gained by knowing that errors are vertical.
  static Scale isotropic(Scale scale) { return {scale.depth_m, scale.any_px, scale.any_px, scale.is_small}; }

  /// The largest e, in metres; negative: none. Where the tile's error alone takes more than three quarters of
  /// the tolerance, a quarter is allowed all the same.
  double error_m(const Scale& scale, double tile_m, double chord_m) const {
    return error_m(room_of(scale), tile_m, chord_m);
  }
  /// The same for many chords: e and g take up this less so much times c.
  struct Room {
    double all_m;
    double per_chord;
  };
  Room room_of(const Scale& scale) const;
  static double error_m(const Room& room, double tile_m, double chord_m) {
    const double left = room.all_m - chord_m * room.per_chord;
    return std::max(left - tile_m, left / 4);
  }

  /// Whether a part of the sphere may be in the picture and above the horizon.
  bool sees(const SquareSphere& sphere) const;

 private:
  glm::dvec3 eye_;
  glm::dvec3 forward_;
  glm::dvec3 right_;
  glm::dvec3 up_;
  std::array<glm::dvec3, 4> inward_;  ///< normals of the picture's sides
  Horizon horizon_;
  double focal_px_;
  double tolerance_px_;
  double corner_cosine_;  ///< of the angle to the picture's corner
};

}  // namespace cairn
