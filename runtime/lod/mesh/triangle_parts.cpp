#include "runtime/lod/mesh/triangle_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>

#include "runtime/lod/mesh/subtriangles_over_tolerance.h"
#include "runtime/lod/mesh/triangle_bound.h"

namespace cairn {
namespace {

/// At most this many parts are tested sample by sample; with more in doubt, the triangle is assumed to
/// exceed.
constexpr int kMaxExactSubtriangles = 2;

/// Let g have third derivatives of at most 1 along any direction. The quadratic through g's values at the
/// corners and edge middles of a right triangle differs from g by at most kThird times the cube of a leg:
/// Taylor's remainder at each of the six places, Σ|Nᵢ||xᵢ−x|³/6, maximised over all x.
constexpr double kThird = 0.047;

/// Bound of the third derivative of a position along any direction of the grid: 1.46 on the unit sphere.
constexpr double kThirdOfEarth_m = 1.6 * 6.4e6;

struct PieceCorner {
  SampleAddress at{};
  double height_m = 0;
  glm::dvec3 drawn{0};  ///< on the flat triangle, in camera coordinates
};

/// A flat triangle, or one of its quarters, which have its shape.
struct TrianglePiece {
  std::array<PieceCorner, 3> corners;  ///< the base, then the right angle
  double leg;                          ///< in radians of longitude and latitude
  bool has_sample_corners;             ///< the corners are samples, so that the surface passes through them
};

PieceCorner between(const PieceCorner& s, const PieceCorner& t) {
  return {{(s.at[0] + t.at[0]) / 2, (s.at[1] + t.at[1]) / 2},
          (s.height_m + t.height_m) / 2,
          (s.drawn + t.drawn) / 2.0};
}

/// Returns a range that holds for all parts.
SubtriangleErrorRanges::Ranges union_of_ranges(const SubtriangleErrorRanges::Ranges& ranges) {
  SubtriangleErrorRanges::Ranges all = ranges;
  all.least.fill(*std::min_element(ranges.least.begin(), ranges.least.end()));
  all.most.fill(*std::max_element(ranges.most.begin(), ranges.most.end()));
  return all;
}

class PartTest {
 public:
  PartTest(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples)
      : view_(view),
        surface_(surface),
        samples_(samples),
        is_partly_hidden_(view.horizon.hides(samples.a.place) || view.horizon.hides(samples.b.place) ||
                          view.horizon.hides(samples.c.place)) {}

  bool any_exceeds() const {
    const TrianglePiece whole = whole_triangle();
    const std::uint32_t parts = parts_over_tolerance(whole, *samples_.stored.ranges);
    if (parts == 0) return false;
    if (surface_.error_m <= 0 && samples_.stored.span <= kMaxExactSpan * SubtriangleErrorRanges::kSteps &&
        std::popcount(parts) <= kMaxExactSubtriangles)
      return any_sample_exceeds_in(parts);
    return whole.leg < kMaxCurvatureLeg ||
           any_quarter_exceeds(whole, union_of_ranges(*samples_.stored.ranges), 2);
  }

 private:
  bool any_sample_exceeds_in(std::uint32_t parts) const {
    const SampleTriangle triangle{samples_.a.at, samples_.b.at, samples_.c.at};
    for (; parts != 0; parts &= parts - 1) {
      const auto part = static_cast<std::size_t>(std::countr_zero(parts));
      if (any_sample_exceeds(view_, surface_, samples_, SubtriangleErrorRanges::corners_of(triangle, part)))
        return true;
    }
    return false;
  }

  /// The Earth curves less over a quarter. The parts' ranges say nothing about quarters, so `ranges` has to
  /// hold for all parts.
  bool any_quarter_exceeds(const TrianglePiece& piece, const SubtriangleErrorRanges::Ranges& ranges,
                           int halvings) const {
    const auto& [a, b, c] = piece.corners;
    const PieceCorner base = between(a, b), of_q = between(b, c), of_p = between(c, a);
    for (const std::array<PieceCorner, 3>& quarter : {std::array{base, c, of_p}, std::array{a, base, of_p},
                                                      std::array{base, b, of_q}, std::array{c, base, of_q}}) {
      const TrianglePiece smaller{quarter, piece.leg / 2, false};
      if (parts_over_tolerance(smaller, ranges) == 0) continue;
      if (halvings == 1 || smaller.leg < kMaxCurvatureLeg ||
          any_quarter_exceeds(smaller, ranges, halvings - 1))
        return true;
    }
    return false;
  }

  std::uint32_t parts_over_tolerance(const TrianglePiece& piece,
                                     const SubtriangleErrorRanges::Ranges& ranges) const {
    const FlatTriangle triangle = flat_triangle(piece, ranges.largest_m() + surface_.error_m);
    const SubtriangleViewport viewport{
        view_.half_width, view_.half_height, kNearest_m,
        samples_.a.in_viewport && samples_.b.in_viewport && samples_.c.in_viewport};
    std::uint32_t parts =
        subtriangles_over_tolerance(triangle, ranges, viewport, view_.tolerance, surface_.error_m);
    if (parts != 0 && surface_.error_m > 0)
      parts &= subtriangles_over_tolerance(triangle, ranges, viewport, view_.tolerance / 4, 0);
    return parts != 0 && is_partly_hidden_ ? above_horizon(triangle, ranges.largest_m(), parts) : parts;
  }

  TrianglePiece whole_triangle() const {
    const auto corner = [](const ProjectedSample& s) { return PieceCorner{s.at, s.height_m, s.in_camera}; };
    const auto& [stored, a, b, c] = samples_;
    const bool is_half = std::abs(a.at[0] - b.at[0]) == std::abs(a.at[1] - b.at[1]);
    return {{corner(a), corner(b), corner(c)},
            stored.span * surface_.errors.cell_radians() / (is_half ? 1 : std::numbers::sqrt2),
            true};
  }

  FlatTriangle flat_triangle(const TrianglePiece& piece, double error_m) const {
    const auto& [a, b, c] = piece.corners;
    FlatTriangle triangle;
    triangle.corners = {a.drawn, b.drawn, c.drawn};
    triangle.ups = {up_at(view_, surface_, a.at), up_at(view_, surface_, b.at), up_at(view_, surface_, c.at)};
    if (!piece.has_sample_corners) triangle.bulges = {bulge_at(a), bulge_at(b), bulge_at(c)};
    triangle.middle_bulges = {bulge_at(between(a, b)), bulge_at(between(b, c)), bulge_at(between(c, a))};
    const double rise = std::max(std::abs(a.height_m - c.height_m), std::abs(b.height_m - c.height_m));
    triangle.slack_m =
        piece.leg * piece.leg * (kThird * (kThirdOfEarth_m * piece.leg + 5.3 * rise) + 0.3 * error_m);
    return triangle;
  }

  glm::dvec3 bulge_at(const PieceCorner& corner) const {
    return corner.drawn - view_.camera.in_camera(
                              surface_.errors.positions().at(corner.at[0], corner.at[1], corner.height_m));
  }

  /// Returns those of the parts that the horizon may not hide: each in a sphere around its middle. S(h) is
  /// linear but for its second-order bulge, which differs from that at the part's middle by at most twice the
  /// largest one.
  std::uint32_t above_horizon(const FlatTriangle& triangle, double error_m, std::uint32_t parts) const {
    constexpr int n = SubtriangleErrorRanges::kSteps;
    const std::array<glm::dvec3, 3> bends = quadratic_bulges(triangle);
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
        const glm::dvec3 place = view_.camera.position + view_.camera.right * middle.x +
                                 view_.camera.up * middle.y + view_.camera.forward * middle.z;
        if (!view_.horizon.hides(place, radius)) above |= 1u << part;
      }
    }
    return above;
  }

  const TriangleView& view_;
  const TileSurface& surface_;
  const CornerSamples& samples_;
  bool is_partly_hidden_;  ///< the horizon hides a corner
};

}  // namespace

bool any_part_exceeds(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples) {
  return PartTest(view, surface, samples).any_exceeds();
}

}  // namespace cairn
