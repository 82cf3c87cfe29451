#include "runtime/lod/mesh/triangle_error.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn {
namespace {

/// What is nearer along the view is treated as at the eye.
constexpr double kNearest_m = 1e-3;

/// Beyond the picture's sides, for what rounding moves over them.
constexpr double kMargin_px = 0.5;

/// Of two ways to project, each to its own rounding.
constexpr double kRounding = 1e-6;

/// Parts of so many cells, on whose samples all depends, are looked at row by row.
constexpr int kRowsSpan = 4;

/// Smaller parts are not asked whether the horizon hides them.
constexpr int kHorizonSpan = 4;

/// Parts of a triangle that are looked at before it is given up: a quarter of the cells that it spans, if
/// these are more.
constexpr int kParts = 32;

/// Times the tolerance, beyond which a triangle's bound is believed. With these two larger, the mesh has some
/// hundredths fewer triangles for some tenths more time, smaller the other way round.
constexpr double kHopeless = 1.5;

/// Radians. Over triangles that are narrower the vertical and the slant of rays change so little that one of
/// each does for all parts.
constexpr double kNarrow = 0.06;

/// Radians. Over triangles that are wider the bound of the Earth's curvature is too coarse to be believed.
constexpr double kWide = 0.05;

double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

/// A displacement where rays have the direction t: f times this, over the depth, is its picture's.
double across(const glm::dvec3& displacement, const glm::dvec2& t) {
  return length(displacement.x - t.x * displacement.z, displacement.y - t.y * displacement.z);
}

double least(double a, double b, double c) {
  return std::min(std::min(a, b), c);
}
double most(double a, double b, double c) {
  return std::max(std::max(a, b), c);
}

}  // namespace

TriangleError::TriangleError(const LodView& view, double lowest_m)
    : camera_(camera_frame(view.view)),
      sample_camera_(camera_),
      horizon_(camera_.position, Occluder(lowest_m)),
      tolerance_(view.tolerance_px * (1 - kRounding)) {
  const double focal_px =
      view.view.viewport_height_px / (2 * std::tan(glm::radians(view.view.fov_y_deg) / 2));
  tolerance_ /= focal_px;
  half_width_ = (view.view.viewport_width_px / 2.0 + kMargin_px) / focal_px;
  half_height_ = (view.view.viewport_height_px / 2.0 + kMargin_px) / focal_px;
}

/// At one triangle.
class TriangleError::Look {
 public:
  Look(const TriangleError& view, const Surface& surface) : view_(view), surface_(surface) {}

  bool exceeds(const std::array<Corner, 3>& triangle) {
    const auto corner = [&](const Corner& at) {
      Sample s = sample(at);
      s.drawn = s.is;
      return s;
    };
    const Sample a = corner(triangle[0]), b = corner(triangle[1]), c = corner(triangle[2]);
    const Part whole{a, b, c, own_of(triangle[0], triangle[1], triangle[2])};
    parts_left_ = std::max(kParts, whole.own.span / 4);
    if (is_hopeless(whole)) return true;
    look_from_afar(whole);
    return is_off(whole);
  }

 private:
  /// In the camera: right, up, and along the view.
  struct Sample {
    Corner at{};
    glm::dvec3 place{0};  ///< geocentric
    glm::dvec3 is{0};
    glm::dvec3 drawn{0};
    glm::dvec2 ray{0};     ///< is⊥ / is.z, if that is above kNearest_m
    bool is_seen = false;  ///< is in the picture, above the horizon or not
    double off = 0;        ///< across(drawn − is, ray)
  };
  /// What a triangle of the hierarchy is off by.
  struct Own {
    double error_m;
    double chord_m;
    int span;  ///< cells along its legs, or along its base where that runs along the grid
  };
  /// A triangle of the hierarchy: its base, then the right angle.
  struct Part {
    const Sample& a;
    const Sample& b;
    const Sample& c;
    Own own;
  };
  /// Of the rays to a part's points.
  struct Rays {
    double turn;   ///< ω
    double slant;  ///< s
    double up;     ///< |up⊥ − t·upz| at the right angle
    double up_z;
    double up_turn;  ///< α
  };

  Sample sample(const Corner& at) const {
    Sample s;
    s.at = at;
    s.place =
        surface_.errors.positions().at(at[0], at[1], surface_.heights.at(at[0], at[1]) * surface_.quantum_m);
    s.is = view_.camera_.in_camera(s.place);
    if (s.is.z > kNearest_m) {
      s.ray = glm::dvec2(s.is.x, s.is.y) * (1 / s.is.z);
      s.is_seen = std::abs(s.ray.x) <= view_.half_width_ && std::abs(s.ray.y) <= view_.half_height_;
    }
    return s;
  }

  Own own_of(const Corner& a, const Corner& b, const Corner& c) const {
    const SquareErrors& errors = surface_.errors;
    const int columns = std::abs(a[0] - b[0]), rows = std::abs(a[1] - b[1]);
    const int span = std::max(columns, rows);
    if (span == 1) return {quarter_of_twist_m(a, b), errors.chord_m(0), 1};
    const int k = std::countr_zero(static_cast<unsigned>(span));
    if (columns == rows) {
      const SquareError& square = errors.at(k, ((a[0] + b[0]) / 2) >> k, ((a[1] + b[1]) / 2) >> k);
      return {length_m(square.centre), errors.chord_m(k), span};
    }
    const unsigned side = rows == 0 ? (a[1] < c[1] ? 0 : 2) : (a[0] > c[0] ? 1 : 3);
    return {length_m(errors.at(k, c[0] >> k, c[1] >> k).middles[side]), errors.chord_m(k) / 2, span};
  }

  /// What half a cell is off by from the tile's bilinear surface, where that stands for finer samples.
  double quarter_of_twist_m(const Corner& a, const Corner& b) const {
    if (surface_.error_m <= 0) return 0;
    const auto height_m = [&](int column, int row) {
      return surface_.heights.at(column, row) * surface_.quantum_m;
    };
    return std::abs(height_m(a[0], a[1]) + height_m(b[0], b[1]) - height_m(a[0], b[1]) -
                    height_m(b[0], a[1])) /
           4;
  }

  bool is_off(const Part& part) {
    const bool is_cell = part.own.span == 1, only_samples = surface_.error_m <= 0;
    if (is_cell && only_samples) return false;
    if (--parts_left_ < 0) return true;
    const bool in_rows = only_samples && part.own.span <= kRowsSpan;
    if (is_within(part) || is_outside(part) || (in_rows && !row_is_off(part))) return false;
    if (in_rows && !is_hidden(part)) return true;
    if (is_cell) return true;
    const Corner &a = part.a.at, &b = part.b.at, &c = part.c.at;
    Sample middle = sample({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2});
    middle.drawn = (part.a.drawn + part.b.drawn) / 2.0;
    middle.off = across(middle.drawn - middle.is, middle.ray);
    if (is_off(middle)) return true;
    const Part before{part.c, part.a, middle, own_of(c, a, middle.at)};
    const Part after{part.b, part.c, middle, own_of(b, c, middle.at)};
    // What is off is found soonest where more is.
    return after.own.error_m > before.own.error_m ? is_off(after) || is_off(before)
                                                  : is_off(before) || is_off(after);
  }

  /// Whether the horizon hides a corner.
  bool is_hidden(const Part& part) const {
    return view_.horizon_.hides(part.a.place) || view_.horizon_.hides(part.b.place) ||
           view_.horizon_.hides(part.c.place);
  }

  /// Of the part's samples, where the horizon hides none.
  bool row_is_off(const Part& part) const {
    std::array<SampleRow, kRowsSpan + 1> rows;
    const Corner &a = part.a.at, &b = part.b.at, &c = part.c.at;
    // Of (column, row) from the right angle: with the legs p and q, (x, y) = λp + μq.
    const int px = a[0] - c[0], py = a[1] - c[1], qx = b[0] - c[0], qy = b[1] - c[1];
    const double area = px * qy - py * qx;
    const glm::dvec3 p = part.a.drawn - part.c.drawn, q = part.b.drawn - part.c.drawn;
    DrawnPlane plane;
    plane.by_column = (p * static_cast<double>(qy) - q * static_cast<double>(py)) / area;
    plane.by_row = (q * static_cast<double>(px) - p * static_cast<double>(qx)) / area;
    plane.at =
        part.c.drawn - static_cast<double>(c[0]) * plane.by_column - static_cast<double>(c[1]) * plane.by_row;
    return any_is_off(rows_of({a, b, c}, rows), surface_.heights, surface_.quantum_m,
                      surface_.errors.positions(), view_.sample_camera_, plane,
                      {view_.half_width_, view_.half_height_, kNearest_m, view_.tolerance_});
  }

  bool is_off(const Sample& s) const {
    if (!s.is_seen) return false;
    const double tile = surface_.error_m > 0 ? surface_.error_m * across(up_at(s.at), s.ray) : 0;
    const double allowed = std::max(view_.tolerance_ * s.drawn.z - tile, view_.tolerance_ / 4 * s.drawn.z);
    return (s.drawn.z < kNearest_m || s.off > allowed) && !view_.horizon_.hides(s.place);
  }

  glm::dvec3 up_at(const Corner& at) const {
    const glm::dvec3 up = surface_.errors.positions().up_at(at[0], at[1]);
    return {glm::dot(up, view_.camera_.right), glm::dot(up, view_.camera_.up),
            glm::dot(up, view_.camera_.forward)};
  }

  /// |ρ| at most.
  double reach_m(const Part& part) const { return part.own.error_m + part.own.chord_m + surface_.error_m; }

  /// What all parts of a narrow triangle can share: the vertical at its right angle and the largest slant.
  void look_from_afar(const Part& whole) {
    const double reach = reach_m(whole), nearest = least(whole.a.is.z, whole.b.is.z, whole.c.is.z) - reach;
    up_turn_ = whole.own.span * surface_.errors.cell_radians();
    is_narrow_ = up_turn_ < kNarrow && reach < nearest * kNarrow;
    if (!is_narrow_) return;
    up_ = up_at(whole.c.at);
    slant_ = slant_of(whole);
    slant_ += reach * slant_ / nearest;
    has_horizon_ = is_hidden(whole);
  }

  /// ω of the part's own points.
  static double turn_of(const Part& part) {
    const glm::dvec2 &a = part.a.ray, &b = part.b.ray, &c = part.c.ray;
    return length(most(a.x, b.x, c.x) - least(a.x, b.x, c.x), most(a.y, b.y, c.y) - least(a.y, b.y, c.y));
  }

  /// Of the part's own points, to which `beyond` is added for what ρ moves them by.
  Rays rays_to(const Part& part, double beyond, double slant) const {
    const glm::dvec3 up = up_at(part.c.at);
    return {turn_of(part) + beyond, slant + beyond, across(up, part.c.ray), std::abs(up.z),
            part.own.span * surface_.errors.cell_radians()};
  }

  /// With what a narrow triangle's parts share.
  Rays narrow_rays_to(const Part& part, double beyond) const {
    return {turn_of(part) + beyond, slant_, across(up_, part.c.ray), std::abs(up_.z), up_turn_};
  }

  static double slant_of(const Part& part) {
    return std::sqrt(1 + most(glm::dot(part.a.ray, part.a.ray), glm::dot(part.b.ray, part.b.ray),
                              glm::dot(part.c.ray, part.c.ray)));
  }

  /// Whether the bound says that no place of the part is off by too much.
  bool is_within(const Part& part) const {
    const Sample &a = part.a, &b = part.b, &c = part.c;
    const double reach = reach_m(part), nearest = least(a.is.z, b.is.z, c.is.z) - reach;
    if (nearest < kNearest_m || least(a.drawn.z, b.drawn.z, c.drawn.z) < kNearest_m) return false;
    const double slant = is_narrow_ ? slant_ : slant_of(part), beyond = reach * slant / nearest;
    const Rays rays = is_narrow_ ? narrow_rays_to(part, beyond) : rays_to(part, beyond, slant);
    const double vertical = std::min(rays.slant, rays.up + rays.turn * rays.up_z + rays.up_turn * rays.slant);
    const auto is_within = [&](double tolerance, double error_m) {
      const auto over = [&](const Sample& s) {
        return s.off + rays.turn * std::abs(s.drawn.z - s.is.z) - tolerance * s.drawn.z;
      };
      return most(over(a), over(b), over(c)) + error_m * vertical + part.own.chord_m * rays.slant <= 0;
    };
    return is_within(view_.tolerance_, part.own.error_m + surface_.error_m) ||
           (surface_.error_m > 0 && is_within(view_.tolerance_ / 4, part.own.error_m));
  }

  /// A guess that saves looking: yes where the vertical error of the whole triangle, which some sample has
  /// (if not the other triangle's at the same base), is too much wherever that is, or where the bound is so
  /// far above the tolerance that what is looked at rarely turns out well.
  bool is_hopeless(const Part& whole) const {
    if (!whole.a.is_seen || !whole.b.is_seen || !whole.c.is_seen) return false;
    const Rays rays = rays_to(whole, 0, slant_of(whole));
    const double error = whole.own.error_m, chord = whole.own.chord_m * rays.slant;
    const double least_vertical = rays.up - rays.turn * rays.up_z - rays.up_turn * rays.slant;
    return error * least_vertical - chord >
               view_.tolerance_ * most(whole.a.is.z, whole.b.is.z, whole.c.is.z) ||
           (rays.up_turn < kWide && error * rays.up + chord > kHopeless * view_.tolerance_ * whole.c.is.z);
  }

  /// Whether nothing of the part is in the picture, certainly.
  bool is_outside(const Part& part) const {
    if (is_beside(part)) return true;
    return part.own.span >= kHorizonSpan && (has_horizon_ || !is_narrow_) && is_below_horizon(part);
  }

  bool is_beside(const Part& part) const {
    if (part.a.is_seen || part.b.is_seen || part.c.is_seen) return false;
    const glm::dvec3 &a = part.a.is, &b = part.b.is, &c = part.c.is;
    const double reach = reach_m(part), w = view_.half_width_, h = view_.half_height_;
    const double reach_w = -reach * length(1, w), reach_h = -reach * length(1, h);
    return most(a.z, b.z, c.z) < -reach || most(a.z * w - a.x, b.z * w - b.x, c.z * w - c.x) < reach_w ||
           most(a.z * w + a.x, b.z * w + b.x, c.z * w + c.x) < reach_w ||
           most(a.z * h - a.y, b.z * h - b.y, c.z * h - c.y) < reach_h ||
           most(a.z * h + a.y, b.z * h + b.y, c.z * h + c.y) < reach_h;
  }

  bool is_below_horizon(const Part& part) const {
    const glm::dvec3 middle = (part.a.place + part.b.place) / 2.0;
    const double radius = std::max(glm::length(part.a.place - middle), glm::length(part.c.place - middle));
    return view_.horizon_.hides(middle, radius + reach_m(part));
  }

  const TriangleError& view_;
  const Surface& surface_;
  int parts_left_ = 0;
  // Of the whole triangle.
  bool is_narrow_ = false;
  bool has_horizon_ = true;  // it may run behind the horizon
  glm::dvec3 up_{0};
  double up_turn_ = 0;
  double slant_ = 1;
};

bool TriangleError::exceeds(const Surface& surface, const std::array<Corner, 3>& triangle) const {
  return Look(*this, surface).exceeds(triangle);
}

}  // namespace cairn
