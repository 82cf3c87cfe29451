#include "runtime/lod/mesh/triangle_error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "runtime/lod/mesh/subtriangles_over_tolerance.h"

namespace cairn {
namespace {

/// What is nearer along the view is treated as at the eye.
constexpr double kNearest_m = 1e-3;

/// Beyond the picture's sides, for what rounding moves over them.
constexpr double kMargin_px = 0.5;

/// Of two ways to project, each to its own rounding.
constexpr double kRounding = 1e-6;

/// Triangles, and parts of them, of at most so many cells are looked at sample by sample.
constexpr int kRowsSpan = 8;

/// Where more parts of a triangle may be off, one of them mostly is. Looked into are as many, or none.
constexpr int kMaxExactSubtriangles = 2;

/// Times the tolerance, beyond which a triangle's bound is believed: of those, hardly any look ends well.
constexpr double kAssumeExceedsAbove = 3;

/// Radians. Over triangles with longer legs the bound of the Earth's curvature is too coarse to be believed,
/// and parts of quarters are looked at where the triangle's own may be off.
constexpr double kWide = 0.1;

/// What a quadratic through the corners and the middles of the edges of a right triangle differs by from
/// what has a third derivative of at most 1 along any direction: so much times the cube of a leg. Worked out
/// with Taylor's remainder at each of the six, Σ|Nᵢ||xᵢ−x|³/6, over all x.
constexpr double kThird = 0.047;

/// The third derivative of a position along any direction of the grid: 1.46 on the unit sphere.
constexpr double kThirdOfEarth_m = 1.6 * 6.4e6;

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

  bool exceeds(const std::array<Corner, 3>& triangle) const {
    const Own own = own_of(triangle);
    const auto corner = [&](std::size_t i) {
      const Corner& at = triangle[i];
      return sample(at, own.ranges != nullptr ? own.ranges->quanta[i] : surface_.heights.at(at[0], at[1]));
    };
    const Sample a = corner(0), b = corner(1), c = corner(2);
    const Whole whole{a, b, c, own};
    const bool only_samples = surface_.error_m <= 0;
    if (own.span == 1 && only_samples) return false;
    const Rays rays = rays_to(whole);
    if (is_within(whole, rays) || is_outside(whole)) return false;
    if (is_hopeless(whole, rays)) return true;
    if (own.ranges != nullptr) return any_part_is_off(whole);
    return !only_samples || whole.own.span > kRowsSpan || any_sample_is_off(whole, triangle);
  }

 private:
  struct Sample {
    Corner at{};
    double height_m = 0;
    glm::dvec3 place{0};   ///< geocentric
    glm::dvec3 is{0};      ///< in the camera: right, up, and along the view
    glm::dvec2 ray{0};     ///< is⊥ / is.z, if that is above kNearest_m
    bool is_seen = false;  ///< is in the picture, above the horizon or not
  };
  /// What a triangle of the hierarchy is off by.
  struct Own {
    double error_m;
    double chord_m;
    int span;  ///< cells along its legs, or along its base where that runs along the grid
    const SubtriangleErrorRanges::Ranges* ranges;
  };
  /// The base, then the right angle.
  struct Whole {
    const Sample& a;
    const Sample& b;
    const Sample& c;
    Own own;
  };
  /// Of a flat triangle.
  struct Point {
    Corner at{};
    double height_m = 0;  ///< h
    glm::dvec3 drawn{0};  ///< in the camera
  };
  /// A flat triangle, or a part of one that is shaped like it.
  struct Flat {
    std::array<Point, 3> corners;  ///< the base's, then the right angle
    double leg;                    ///< in radians of longitude and latitude
    bool is_whole;                 ///< its corners are samples
  };
  /// Of the rays to a triangle's points.
  struct Rays {
    double turn;   ///< ω
    double slant;  ///< s
    double up;     ///< |up⊥ − t·upz| at the right angle
    double up_z;
    double up_turn;  ///< α
  };

  Sample sample(const Corner& at, std::int32_t quanta) const {
    Sample s;
    s.at = at;
    s.height_m = quanta * surface_.quantum_m;
    s.place = surface_.errors.positions().at(at[0], at[1], s.height_m);
    s.is = view_.camera_.in_camera(s.place);
    if (s.is.z > kNearest_m) {
      s.ray = glm::dvec2(s.is.x, s.is.y) * (1 / s.is.z);
      s.is_seen = std::abs(s.ray.x) <= view_.half_width_ && std::abs(s.ray.y) <= view_.half_height_;
    }
    return s;
  }

  Own own_of(const std::array<Corner, 3>& triangle) const {
    const auto& [a, b, c] = triangle;
    const SquareErrors& errors = surface_.errors;
    const int columns = std::abs(a[0] - b[0]), rows = std::abs(a[1] - b[1]);
    const int span = std::max(columns, rows);
    if (span == 1) return {quarter_of_twist_m(a, b), errors.chord_m(0), 1, nullptr};
    const int k = std::countr_zero(static_cast<unsigned>(span));
    const bool across = columns == rows;
    const double chord_m = across ? errors.chord_m(k) : errors.chord_m(k) / 2;
    if (span >= SubtriangleErrorRanges::kLeastSpan) {
      const SubtriangleErrorRanges::Ranges& ranges = surface_.ranges.of(triangle);
      return {ranges.most_m(), chord_m, span, &ranges};
    }
    if (across)
      return {length_m(errors.at(k, ((a[0] + b[0]) / 2) >> k, ((a[1] + b[1]) / 2) >> k).centre), chord_m,
              span, nullptr};
    const unsigned side = rows == 0 ? (a[1] < c[1] ? 0 : 2) : (a[0] > c[0] ? 1 : 3);
    return {length_m(errors.at(k, c[0] >> k, c[1] >> k).middles[side]), chord_m, span, nullptr};
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

  /// Whether the horizon hides a corner.
  bool is_hidden(const Whole& whole) const {
    return view_.horizon_.hides(whole.a.place) || view_.horizon_.hides(whole.b.place) ||
           view_.horizon_.hides(whole.c.place);
  }

  /// Any sample within these corners, where the horizon hides none.
  bool any_sample_is_off(const Whole& whole, std::span<const Corner> corners) const {
    std::array<SampleRow, kRowsSpan + 1> rows;
    const Corner &a = whole.a.at, &b = whole.b.at, &c = whole.c.at;
    // Of (column, row) from the right angle: with the legs p and q, (x, y) = λp + μq.
    const int px = a[0] - c[0], py = a[1] - c[1], qx = b[0] - c[0], qy = b[1] - c[1];
    const double area = px * qy - py * qx;
    const glm::dvec3 p = whole.a.is - whole.c.is, q = whole.b.is - whole.c.is;
    DrawnPlane plane;
    plane.by_column = (p * static_cast<double>(qy) - q * static_cast<double>(py)) / area;
    plane.by_row = (q * static_cast<double>(px) - p * static_cast<double>(qx)) / area;
    plane.at =
        whole.c.is - static_cast<double>(c[0]) * plane.by_column - static_cast<double>(c[1]) * plane.by_row;
    return any_is_off(rows_of(corners, rows), surface_.heights, surface_.quantum_m,
                      surface_.errors.positions(), view_.sample_camera_, plane,
                      {view_.half_width_, view_.half_height_, kNearest_m, view_.tolerance_});
  }

  /// Of a triangle with ranges.
  bool any_part_is_off(const Whole& whole) const {
    const Flat flat = flat_of(whole);
    const bool runs_behind = is_hidden(whole);
    const std::uint32_t off = subtriangles_over_tolerance(whole, flat, *whole.own.ranges, runs_behind);
    if (off == 0) return false;
    if (surface_.error_m <= 0 && whole.own.span <= kRowsSpan * SubtriangleErrorRanges::kSteps &&
        std::popcount(off) <= kMaxExactSubtriangles) {
      const std::array<Corner, 3> triangle{whole.a.at, whole.b.at, whole.c.at};
      return any_part(off, [&](int part) {
        return any_sample_is_off(
            whole, SubtriangleErrorRanges::corners_of(triangle, static_cast<std::size_t>(part)));
      });
    }
    return flat.leg < kWide || any_quarter_is_off(whole, flat, widest(*whole.own.ranges), runs_behind, 2);
  }

  template <class Is>
  static bool any_part(std::uint32_t parts, const Is& is) {
    for (; parts != 0; parts &= parts - 1) {
      if (is(std::countr_zero(parts))) return true;
    }
    return false;
  }

  /// Of a wide triangle, quarter by quarter: where the Earth curves less. How far the surface is from it is
  /// not known by their parts.
  bool any_quarter_is_off(const Whole& whole, const Flat& flat, const SubtriangleErrorRanges::Ranges& ranges,
                          bool runs_behind, int halvings) const {
    const auto& [a, b, c] = flat.corners;
    const Point base = between(a, b), of_q = between(b, c), of_p = between(c, a);
    for (const std::array<Point, 3>& quarter : {std::array{base, c, of_p}, std::array{a, base, of_p},
                                                std::array{base, b, of_q}, std::array{c, base, of_q}}) {
      const Flat smaller{quarter, flat.leg / 2, false};
      if (subtriangles_over_tolerance(whole, smaller, ranges, runs_behind) == 0) continue;
      if (halvings == 1 || smaller.leg < kWide ||
          any_quarter_is_off(whole, smaller, ranges, runs_behind, halvings - 1))
        return true;
    }
    return false;
  }

  /// What all parts have at most.
  static SubtriangleErrorRanges::Ranges widest(const SubtriangleErrorRanges::Ranges& ranges) {
    SubtriangleErrorRanges::Ranges all = ranges;
    all.least.fill(*std::min_element(ranges.least.begin(), ranges.least.end()));
    all.most.fill(*std::max_element(ranges.most.begin(), ranges.most.end()));
    return all;
  }

  /// Those that may be in the picture and off by too much.
  std::uint32_t subtriangles_over_tolerance(const Whole& whole, const Flat& flat,
                                            const SubtriangleErrorRanges::Ranges& ranges,
                                            bool runs_behind) const {
    const FlatTriangle triangle = triangle_of(flat, ranges.most_m() + surface_.error_m);
    const SubtriangleViewport picture{view_.half_width_, view_.half_height_, kNearest_m,
                                      whole.a.is_seen && whole.b.is_seen && whole.c.is_seen};
    std::uint32_t off =
        cairn::subtriangles_over_tolerance(triangle, ranges, picture, view_.tolerance_, surface_.error_m);
    if (off != 0 && surface_.error_m > 0)
      off &= cairn::subtriangles_over_tolerance(triangle, ranges, picture, view_.tolerance_ / 4, 0);
    return off != 0 && runs_behind ? above_horizon(triangle, ranges.most_m(), off) : off;
  }

  Flat flat_of(const Whole& whole) const {
    const auto point = [](const Sample& s) { return Point{s.at, s.height_m, s.is}; };
    const bool is_half = std::abs(whole.a.at[0] - whole.b.at[0]) == std::abs(whole.a.at[1] - whole.b.at[1]);
    return {{point(whole.a), point(whole.b), point(whole.c)},
            whole.own.span * surface_.errors.cell_radians() / (is_half ? 1 : std::numbers::sqrt2),
            true};
  }

  static Point between(const Point& s, const Point& t) {
    return {{(s.at[0] + t.at[0]) / 2, (s.at[1] + t.at[1]) / 2},
            (s.height_m + t.height_m) / 2,
            (s.drawn + t.drawn) / 2.0};
  }

  FlatTriangle triangle_of(const Flat& flat, double error_m) const {
    const auto& [a, b, c] = flat.corners;
    FlatTriangle triangle;
    triangle.corners = {a.drawn, b.drawn, c.drawn};
    triangle.ups = {up_at(a.at), up_at(b.at), up_at(c.at)};
    if (!flat.is_whole) triangle.bulges = {bulge_at(a), bulge_at(b), bulge_at(c)};
    triangle.middle_bulges = {bulge_at(between(a, b)), bulge_at(between(b, c)), bulge_at(between(c, a))};
    const double rise = std::max(std::abs(a.height_m - c.height_m), std::abs(b.height_m - c.height_m));
    triangle.slack_m =
        flat.leg * flat.leg * (kThird * (kThirdOfEarth_m * flat.leg + 5.3 * rise) + 0.3 * error_m);
    return triangle;
  }

  /// D − S(h).
  glm::dvec3 bulge_at(const Point& point) const {
    return point.drawn -
           view_.camera_.in_camera(surface_.errors.positions().at(point.at[0], point.at[1], point.height_m));
  }

  glm::dvec3 up_at(const Corner& at) const {
    const glm::dvec3 up = surface_.errors.positions().up_at(at[0], at[1]);
    return {glm::dot(up, view_.camera_.right), glm::dot(up, view_.camera_.up),
            glm::dot(up, view_.camera_.forward)};
  }

  /// |ρ| at most.
  double reach_m(const Whole& whole) const {
    return whole.own.error_m + whole.own.chord_m + surface_.error_m;
  }

  /// ω of the triangle's own points.
  static double turn_of(const Whole& whole) {
    const glm::dvec2 &a = whole.a.ray, &b = whole.b.ray, &c = whole.c.ray;
    return length(most(a.x, b.x, c.x) - least(a.x, b.x, c.x), most(a.y, b.y, c.y) - least(a.y, b.y, c.y));
  }

  Rays rays_to(const Whole& whole) const {
    const glm::dvec3 up = up_at(whole.c.at);
    const double slant =
        std::sqrt(1 + most(glm::dot(whole.a.ray, whole.a.ray), glm::dot(whole.b.ray, whole.b.ray),
                           glm::dot(whole.c.ray, whole.c.ray)));
    return {turn_of(whole), slant, across(up, whole.c.ray), std::abs(up.z),
            whole.own.span * surface_.errors.cell_radians()};
  }

  /// Whether the bound says that no place is off by too much.
  bool is_within(const Whole& whole, const Rays& rays) const {
    const double reach = reach_m(whole), nearest = least(whole.a.is.z, whole.b.is.z, whole.c.is.z);
    if (nearest - reach < kNearest_m) return false;
    const double beyond = reach * rays.slant / (nearest - reach), turn = rays.turn + beyond,
                 slant = rays.slant + beyond;
    const double vertical = std::min(slant, rays.up + turn * rays.up_z + rays.up_turn * slant);
    const auto within = [&](double tolerance, double error_m) {
      return error_m * vertical + whole.own.chord_m * slant <= tolerance * nearest;
    };
    return within(view_.tolerance_, whole.own.error_m + surface_.error_m) ||
           (surface_.error_m > 0 && within(view_.tolerance_ / 4, whole.own.error_m));
  }

  /// A guess that saves looking: yes where the vertical error of the whole triangle, which some sample has
  /// (if not the other triangle's at the same base), is too much wherever that is, or where the bound is so
  /// far above the tolerance that what is looked at rarely turns out well.
  bool is_hopeless(const Whole& whole, const Rays& rays) const {
    if (!whole.a.is_seen || !whole.b.is_seen || !whole.c.is_seen) return false;
    const double error = whole.own.error_m, chord = whole.own.chord_m * rays.slant;
    const double least_vertical = rays.up - rays.turn * rays.up_z - rays.up_turn * rays.slant;
    return error * least_vertical - chord >
               view_.tolerance_ * most(whole.a.is.z, whole.b.is.z, whole.c.is.z) ||
           (rays.up_turn < kWide &&
            error * rays.up + chord > kAssumeExceedsAbove * view_.tolerance_ * whole.c.is.z);
  }

  /// Whether nothing of it is in the picture, certainly.
  bool is_outside(const Whole& whole) const {
    const double reach = reach_m(whole);
    if (!whole.a.is_seen && !whole.b.is_seen && !whole.c.is_seen &&
        is_beside(std::array{whole.a.is, whole.b.is, whole.c.is}, reach))
      return true;
    return is_below_horizon(std::array{whole.a.place, whole.b.place, whole.c.place}, reach);
  }

  /// Those of the parts that the horizon may not hide: each in a sphere around its middle. S(h) is linear but
  /// for its bends, which anywhere in a part differ from those at its middle by twice the largest at most.
  std::uint32_t above_horizon(const FlatTriangle& triangle, double error_m, std::uint32_t parts) const {
    constexpr int n = SubtriangleErrorRanges::kSteps;
    const std::array<glm::dvec3, 3> bends = bends_of(triangle);
    const auto& [a, b, c] = triangle.corners;
    const auto& [bulge_a, bulge_b, bulge_c] = triangle.bulges;
    const glm::dvec3 from = c - bulge_c, p = a - bulge_a - from, q = b - bulge_b - from;
    const double most_bent = std::max({glm::length(bends[0]), glm::length(bends[1]), glm::length(bends[2])});
    const double radius = std::max(glm::length(p + q), glm::length(p - q)) / (2 * n) + 2 * most_bent +
                          error_m + surface_.error_m + triangle.slack_m;
    std::uint32_t above = 0;
    for (int j = 0, part = 0; j < n; ++j) {
      for (int i = 0; i + j < n; ++i, ++part) {
        if ((parts >> part & 1) == 0) continue;
        const double u = (i + 0.5) / n, v = (j + 0.5) / n, w = 1 - u - v;
        const glm::dvec3 middle =
            from + u * p + v * q - 4.0 * (u * v * bends[0] + v * w * bends[1] + w * u * bends[2]);
        const glm::dvec3 place = view_.camera_.position + view_.camera_.right * middle.x +
                                 view_.camera_.up * middle.y + view_.camera_.forward * middle.z;
        if (!view_.horizon_.hides(place, radius)) above |= 1u << part;
      }
    }
    return above;
  }

  /// Of places that are so far from these at most, in the camera, and between.
  template <std::size_t kCount>
  bool is_beside(const std::array<glm::dvec3, kCount>& points, double reach) const {
    const double w = view_.half_width_, h = view_.half_height_;
    const double reach_w = -reach * length(1, w), reach_h = -reach * length(1, h);
    const auto all = [&](auto beyond) { return std::all_of(points.begin(), points.end(), beyond); };
    return all([&](const glm::dvec3& p) { return p.z < -reach; }) ||
           all([&](const glm::dvec3& p) { return p.z * w - p.x < reach_w; }) ||
           all([&](const glm::dvec3& p) { return p.z * w + p.x < reach_w; }) ||
           all([&](const glm::dvec3& p) { return p.z * h - p.y < reach_h; }) ||
           all([&](const glm::dvec3& p) { return p.z * h + p.y < reach_h; });
  }

  template <std::size_t kCount>
  bool is_below_horizon(const std::array<glm::dvec3, kCount>& points, double reach) const {
    if (!view_.horizon_.hides(points[0])) return false;
    glm::dvec3 middle{0};
    for (const glm::dvec3& p : points) middle += p;
    middle /= static_cast<double>(kCount);
    double radius = 0;
    for (const glm::dvec3& p : points) radius = std::max(radius, glm::length(p - middle));
    return view_.horizon_.hides(middle, radius + reach);
  }

  const TriangleError& view_;
  const Surface& surface_;
};

bool TriangleError::exceeds(const Surface& surface, const std::array<Corner, 3>& triangle) const {
  return Look(*this, surface).exceeds(triangle);
}

}  // namespace cairn
