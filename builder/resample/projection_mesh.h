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

/// A step at which a mesh of a projection is usually within 1e-4 of a place, up to 84° of latitude: 16 places
/// or 1/16 degree, the smaller; 64 where places are dense, 1/128 degree or less.
std::int64_t projection_mesh_step(double places_per_degree);

/// A smooth but costly map from whole-numbered places to the plane, evaluated at every step-th place (by
/// absolute index, so that any two windows agree) and bicubic, by Lagrange's formula, in between. Each cell
/// of the mesh is held against the map at its centre; where they differ by more than the tolerance, or the
/// map is not finite, as at a pole, beside an antimeridian or at the rim of a projection's domain, the cell's
/// places are the map's own.
class ProjectionMesh {
 public:
  using Map = std::function<PlanePoint(std::int64_t x, std::int64_t y)>;

  /// `tolerance`: in the plane's units. REQUIRES: step > 0.
  ProjectionMesh(IndexWindow places, std::int64_t step, double tolerance, Map map);

  /// The places of a row. REQUIRES: y is in the window; out.size() == columns of the window.
  void row(std::int64_t y, std::span<PlanePoint> out) const;

 private:
  // The four nodes that a place is interpolated from: the first of them, and their weights.
  struct Stencil {
    std::int64_t first = 0;
    std::array<double, 4> weights{};
  };
  Stencil stencil_of(std::int64_t place) const;
  bool is_smooth(std::int64_t cell_x, std::int64_t cell_y, double tolerance) const;

  IndexWindow places_;
  std::int64_t step_;
  Map map_;
  IndexWindow nodes_;  // in units of step
  IndexWindow cells_;  // likewise: cell (i, j) lies north-east of node (i, j)
  std::vector<PlanePoint> points_;
  std::vector<bool> smooth_;     // by cell
  std::vector<double> weights_;  // across, by place between two nodes: step_ of each node's
};

}  // namespace cairn
