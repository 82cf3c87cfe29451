#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "builder/resample/index_window.h"

namespace cairn {

struct PlanePoint {
  double x = 0;
  double y = 0;
};

/// The step at which a mesh of a projection is within 1e-4 of a place, up to 84° of latitude: 16 places or
/// 1/16 degree, the smaller; 64 where places are dense, 1/128 degree or less.
std::int64_t projection_mesh_step(double places_per_degree);

/// A smooth but costly map from whole-numbered places to the plane, evaluated at every step-th place (by
/// absolute index, so that any two windows agree) and bicubic, by Lagrange's formula, in between.
class ProjectionMesh {
 public:
  using Map = std::function<PlanePoint(std::int64_t x, std::int64_t y)>;

  /// REQUIRES: step > 0.
  ProjectionMesh(IndexWindow places, std::int64_t step, const Map& map);

  /// The places of a row. REQUIRES: y is in the window; out.size() == columns of the window.
  void row(std::int64_t y, std::span<PlanePoint> out) const;

 private:
  // The four nodes that a place is interpolated from: the first of them, and their weights.
  struct Stencil {
    std::int64_t first = 0;
    std::array<double, 4> weights{};
  };
  Stencil stencil_of(std::int64_t place) const;

  IndexWindow places_;
  std::int64_t step_;
  IndexWindow nodes_;  // in units of step
  std::vector<PlanePoint> points_;
  std::vector<double> weights_;  // across, by place between two nodes: step_ of each node's
};

}  // namespace cairn
