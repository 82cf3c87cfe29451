#include "cairn/bounding_volume.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr int kSteps = 4;
constexpr std::size_t kSamples = (kSteps + 1) * (kSteps + 1);
using Samples = std::array<glm::dvec3, kSamples>;

GeoBounds inside_world(const GeoBounds& area) {
  return {area.west, area.south, std::min(area.east, 180.0), std::min(area.north, 90.0)};
}

Samples sample_surface(const GeoBounds& area, double height_m, const Ellipsoid& ellipsoid) {
  Samples samples;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const LonLat place{area.west + area.width() * i / kSteps, area.south + area.height() * j / kSteps};
      samples[static_cast<std::size_t>(j * (kSteps + 1) + i)] = to_geocentric(place, height_m, ellipsoid);
    }
  }
  return samples;
}

/// How far the surface may lie from the convex hull of its samples. The second derivatives of an ellipsoid's
/// position are a little above its largest radius of curvature: 2 % covers flattenings of up to 1/20.
double sag_m(const GeoBounds& area, double max_m, const Ellipsoid& ellipsoid) {
  const double lon = glm::radians(area.width()) / kSteps;
  const double lat = glm::radians(area.height()) / kSteps;
  return 1.02 * (largest_curvature_m(ellipsoid) + std::max(max_m, 0.0)) * (lon * lon + lat * lat) / 8;
}

struct Extent {
  double low = INFINITY;
  double high = -INFINITY;
};

void set_box(BoundingVolume& volume, const LocalFrame& frame, const Samples& low, const Samples& high,
             double sag) {
  const std::array<glm::dvec3, 3> axes{frame.east, frame.north, frame.up};
  const glm::dvec3 origin = low[kSamples / 2];
  volume.centre = origin;
  for (std::size_t a = 0; a < 3; ++a) {
    Extent extent;
    for (const Samples* samples : {&low, &high}) {
      for (const glm::dvec3& sample : *samples) {
        const double along = glm::dot(sample - origin, axes[a]);
        extent = {std::min(extent.low, along), std::max(extent.high, along)};
      }
    }
    volume.centre += axes[a] * ((extent.low + extent.high) / 2);
    volume.half_axes[a] = axes[a] * ((extent.high - extent.low) / 2 + sag);
  }
}

/// Each sample is a ball of radius `sag` (scaled), so that the balls' hull holds the surface. What lies
/// behind the horizon's plane and inside its cone is convex, so that where all balls are hidden their hull
/// is.
std::optional<glm::dvec3> horizon_point(const Samples& samples, double sag, const Occluder& occluder) {
  const glm::dvec3 direction = glm::normalize(samples[kSamples / 2] / occluder.radii);
  const double grow = sag / occluder.radii.z;
  double farthest = 0;
  for (const glm::dvec3& sample : samples) {
    const glm::dvec3 scaled = sample / occluder.radii;
    const double distance = glm::length(scaled);
    const double magnitude = std::max(1.0, distance + grow);
    const double cosine = std::clamp(glm::dot(scaled, direction) / distance, -1.0, 1.0);
    const double angle =
        std::acos(cosine) + std::asin(std::min(1.0, grow / distance)) + std::acos(1 / magnitude);
    if (angle >= glm::radians(89.0)) return std::nullopt;
    farthest = std::max(farthest, 1 / std::cos(angle));
  }
  return direction * farthest;
}

}  // namespace

Occluder::Occluder(double lowest_m, const Ellipsoid& body)
    : ellipsoid(body), radii(body.semi_major_m, body.semi_major_m, body.semi_minor_m) {
  assert(lowest_m > -body.semi_minor_m / 2);
  radii += glm::dvec3(std::min(lowest_m, 0.0));
}

double BoundingVolume::distance_m(const glm::dvec3& point) const {
  const glm::dvec3 to = point - centre;
  double square = 0;
  for (const glm::dvec3& half_axis : half_axes) {
    const double half = glm::length(half_axis);
    const double outside = std::max(std::abs(glm::dot(to, half_axis)) / half - half, 0.0);
    square += outside * outside;
  }
  return std::sqrt(square);
}

BoundingVolume bounding_volume(const GeoBounds& area, double min_m, double max_m, const Occluder& occluder) {
  assert(min_m <= max_m);
  const GeoBounds inside = inside_world(area);
  const Samples low = sample_surface(inside, min_m, occluder.ellipsoid);
  const Samples high = sample_surface(inside, max_m, occluder.ellipsoid);
  const double sag = sag_m(inside, max_m, occluder.ellipsoid);
  BoundingVolume volume;
  const LonLat middle{inside.west + inside.width() / 2, inside.south + inside.height() / 2};
  set_box(volume, local_frame(middle), low, high, sag);
  volume.horizon_point = horizon_point(high, sag, occluder);
  return volume;
}

BoundingVolume grown(BoundingVolume volume, double metres) {
  for (glm::dvec3& axis : volume.half_axes) {
    const double length = glm::length(axis);
    if (length > 0) axis *= 1 + metres / length;
  }
  volume.horizon_point.reset();
  return volume;
}

}  // namespace cairn
