#include "runtime/lod/mesh/triangle_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "runtime/view/screen_scale.h"

namespace cairn {
namespace {

constexpr double kMargin_px = 0.5;

/// The tests here and the measure of Screen project in two ways, each with its own rounding.
constexpr double kEdgeRounding = 1e-6;

/// How far half a cell is from the tile's bilinear surface, where the tile stands for finer samples.
double quarter_of_twist_m(const TileSurface& surface, const SampleAddress& a, const SampleAddress& b) {
  if (surface.error_m <= 0) return 0;
  const auto height_m = [&](int column, int row) {
    return surface.heights.at(column, row) * surface.quantum_m;
  };
  return std::abs(height_m(a[0], a[1]) + height_m(b[0], b[1]) - height_m(a[0], b[1]) - height_m(b[0], a[1])) /
         4;
}

ProjectedSample project(const TriangleView& view, const TileSurface& surface, const SampleAddress& at,
                        std::int32_t quanta) {
  ProjectedSample s;
  s.at = at;
  s.height_m = quanta * surface.quantum_m;
  s.place = surface.errors.positions().at(at[0], at[1], s.height_m);
  s.in_camera = view.camera.in_camera(s.place);
  if (s.in_camera.z > kNearest_m) {
    s.ray = glm::dvec2(s.in_camera.x, s.in_camera.y) * (1 / s.in_camera.z);
    s.in_viewport = std::abs(s.ray.x) <= view.half_width && std::abs(s.ray.y) <= view.half_height;
  }
  return s;
}

ProjectedSample corner(const TriangleView& view, const TileSurface& surface, const SampleTriangle& triangle,
                       const StoredError& stored, std::size_t i) {
  const SampleAddress& at = triangle[i];
  return project(view, surface, at,
                 stored.ranges != nullptr ? stored.ranges->quanta[i] : surface.heights.at(at[0], at[1]));
}

}  // namespace

TriangleView::TriangleView(const LodView& view, double lowest_m)
    : camera(camera_frame(view.view)),
      sample_camera(camera),
      horizon(camera.position, Occluder(lowest_m, view.view.ellipsoid)),
      tolerance(view.tolerance_px * (1 - kEdgeRounding)) {
  const double focal_px = pixels_per_radian(view.view);
  tolerance /= focal_px;
  half_width = (view.view.viewport_width_px / 2.0 + kMargin_px) / focal_px;
  half_height = (view.view.viewport_height_px / 2.0 + kMargin_px) / focal_px;
}

StoredError stored_error_of(const TileSurface& surface, const SampleTriangle& triangle) {
  const auto& [a, b, c] = triangle;
  const SquareErrors& errors = surface.errors;
  const int columns = std::abs(a[0] - b[0]), rows = std::abs(a[1] - b[1]);
  const int span = std::max(columns, rows);
  if (span == 1) return {quarter_of_twist_m(surface, a, b), errors.sagitta_m(0), 1, nullptr};
  const int k = std::countr_zero(static_cast<unsigned>(span));
  const bool is_diagonal = columns == rows;
  const double sagitta_m = is_diagonal ? errors.sagitta_m(k) : errors.sagitta_m(k) / 2;
  if (span >= SubtriangleErrorRanges::kLeastSpan) {
    const SubtriangleErrorRanges::Ranges& ranges = surface.ranges.of(triangle);
    return {ranges.largest_m(), sagitta_m, span, &ranges};
  }
  if (is_diagonal)
    return {decode_length_m(errors.at(k, ((a[0] + b[0]) / 2) >> k, ((a[1] + b[1]) / 2) >> k).centre),
            sagitta_m, span, nullptr};
  const unsigned side = rows == 0 ? (a[1] < c[1] ? 0 : 2) : (a[0] > c[0] ? 1 : 3);
  return {decode_length_m(errors.at(k, c[0] >> k, c[1] >> k).middles[side]), sagitta_m, span, nullptr};
}

CornerSamples::CornerSamples(const TriangleView& view, const TileSurface& surface,
                             const SampleTriangle& triangle, const StoredError& error)
    : stored(error),
      a(corner(view, surface, triangle, error, 0)),
      b(corner(view, surface, triangle, error, 1)),
      c(corner(view, surface, triangle, error, 2)) {}

glm::dvec3 up_at(const TriangleView& view, const TileSurface& surface, const SampleAddress& at) {
  const glm::dvec3 up = surface.errors.positions().up_at(at[0], at[1]);
  return {glm::dot(up, view.camera.right), glm::dot(up, view.camera.up), glm::dot(up, view.camera.forward)};
}

bool any_sample_exceeds(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples,
                        std::span<const SampleAddress> corners) {
  std::array<SampleRow, kMaxExactSpan + 1> rows;
  const SampleAddress &a = samples.a.at, &b = samples.b.at, &c = samples.c.at;
  // (x, y) = (column, row) from the right angle = λp + μq, where p and q are the legs.
  const int px = a[0] - c[0], py = a[1] - c[1], qx = b[0] - c[0], qy = b[1] - c[1];
  const double area = px * qy - py * qx;
  const glm::dvec3 p = samples.a.in_camera - samples.c.in_camera,
                   q = samples.b.in_camera - samples.c.in_camera;
  DrawnPlane plane;
  plane.by_column = (p * static_cast<double>(qy) - q * static_cast<double>(py)) / area;
  plane.by_row = (q * static_cast<double>(px) - p * static_cast<double>(qx)) / area;
  plane.at = samples.c.in_camera - static_cast<double>(c[0]) * plane.by_column -
             static_cast<double>(c[1]) * plane.by_row;
  return any_sample_exceeds(rows_of(corners, rows), surface.heights, surface.quantum_m,
                            surface.errors.positions(), view.sample_camera, plane,
                            {view.half_width, view.half_height, kNearest_m, view.tolerance});
}

}  // namespace cairn
