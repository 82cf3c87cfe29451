#include "runtime/lod/mesh/triangle_bound.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>

namespace cairn {
namespace {

/// Multiple of the tolerance. A triangle whose bound is larger almost never passes the exact test.
constexpr double kAssumeExceedsAbove = 3;

double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

/// Returns a displacement's part across rays of the direction t: f times it, over the depth, is in pixels.
double across(const glm::dvec3& displacement, const glm::dvec2& t) {
  return length(displacement.x - t.x * displacement.z, displacement.y - t.y * displacement.z);
}

double least(double a, double b, double c) {
  return std::min(std::min(a, b), c);
}
double most(double a, double b, double c) {
  return std::max(std::max(a, b), c);
}

/// Returns whether all places within `reach_m` of these points and between them are outside the viewport.
bool is_outside_viewport(const TriangleView& view, const std::array<glm::dvec3, 3>& points, double reach_m) {
  const double w = view.half_width, h = view.half_height;
  const double reach_w = -reach_m * length(1, w), reach_h = -reach_m * length(1, h);
  const auto all = [&](auto beyond) { return std::all_of(points.begin(), points.end(), beyond); };
  return all([&](const glm::dvec3& p) { return p.z < -reach_m; }) ||
         all([&](const glm::dvec3& p) { return p.z * w - p.x < reach_w; }) ||
         all([&](const glm::dvec3& p) { return p.z * w + p.x < reach_w; }) ||
         all([&](const glm::dvec3& p) { return p.z * h - p.y < reach_h; }) ||
         all([&](const glm::dvec3& p) { return p.z * h + p.y < reach_h; });
}

bool is_below_horizon(const TriangleView& view, const std::array<glm::dvec3, 3>& points, double reach_m) {
  if (!view.horizon.hides(points[0])) return false;
  glm::dvec3 middle{0};
  for (const glm::dvec3& p : points) middle += p;
  middle /= static_cast<double>(points.size());
  double radius = 0;
  for (const glm::dvec3& p : points) radius = std::max(radius, glm::length(p - middle));
  return view.horizon.hides(middle, radius + reach_m);
}

double turn_of(const CornerSamples& samples) {
  const glm::dvec2 &a = samples.a.ray, &b = samples.b.ray, &c = samples.c.ray;
  return length(most(a.x, b.x, c.x) - least(a.x, b.x, c.x), most(a.y, b.y, c.y) - least(a.y, b.y, c.y));
}

}  // namespace

TriangleBound::TriangleBound(const TriangleView& view, const TileSurface& surface,
                             const CornerSamples& samples)
    : view_(view), surface_(surface), samples_(samples), turn_(turn_of(samples)) {
  const glm::dvec3 up = up_at(view, surface, samples.c.at);
  slant_ = std::sqrt(1 + most(glm::dot(samples.a.ray, samples.a.ray), glm::dot(samples.b.ray, samples.b.ray),
                              glm::dot(samples.c.ray, samples.c.ray)));
  up_ = across(up, samples.c.ray);
  up_z_ = std::abs(up.z);
  up_turn_ = samples.stored.span * surface.errors.cell_radians();
}

double TriangleBound::reach_m() const {
  return samples_.stored.error_m + samples_.stored.sagitta_m + surface_.error_m;
}

bool TriangleBound::is_within() const {
  const double reach = reach_m(),
               nearest = least(samples_.a.in_camera.z, samples_.b.in_camera.z, samples_.c.in_camera.z);
  if (nearest - reach < kNearest_m) return false;
  const double beyond = reach * slant_ / (nearest - reach), turn = turn_ + beyond, slant = slant_ + beyond;
  const double vertical = std::min(slant, up_ + turn * up_z_ + up_turn_ * slant);
  const auto within = [&](double tolerance, double error_m) {
    return error_m * vertical + samples_.stored.sagitta_m * slant <= tolerance * nearest;
  };
  return within(view_.tolerance, samples_.stored.error_m + surface_.error_m) ||
         (surface_.error_m > 0 && within(view_.tolerance / 4, samples_.stored.error_m));
}

bool TriangleBound::is_invisible() const {
  const double reach = reach_m();
  const auto& [stored, a, b, c] = samples_;
  if (!a.in_viewport && !b.in_viewport && !c.in_viewport &&
      is_outside_viewport(view_, {a.in_camera, b.in_camera, c.in_camera}, reach))
    return true;
  return is_below_horizon(view_, {a.place, b.place, c.place}, reach);
}

bool TriangleBound::assume_exceeds() const {
  const auto& [stored, a, b, c] = samples_;
  if (!a.in_viewport || !b.in_viewport || !c.in_viewport) return false;
  const double error = stored.error_m, sagitta = stored.sagitta_m * slant_;
  const double least_vertical = up_ - turn_ * up_z_ - up_turn_ * slant_;
  return error * least_vertical - sagitta >
             view_.tolerance * most(a.in_camera.z, b.in_camera.z, c.in_camera.z) ||
         (up_turn_ < kMaxCurvatureLeg &&
          error * up_ + sagitta > kAssumeExceedsAbove * view_.tolerance * c.in_camera.z);
}

}  // namespace cairn
