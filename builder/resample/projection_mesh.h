#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "builder/resample/index_window.h"

namespace cairn {

struct PlanePoint {
  double x = 0;
  double y = 0;
};

/// What lies out of a projection's reach.
inline constexpr PlanePoint kNowhere{std::numeric_limits<double>::quiet_NaN(),
                                     std::numeric_limits<double>::quiet_NaN()};

/// A step at which a mesh of a projection is usually within 1e-4 of a place, up to 84° of latitude: 16 places
/// or 1/16 degree, the smaller; 64 where places are dense, 1/128 degree or less.
std::int64_t projection_mesh_step(double places_per_degree);

/// A smooth but costly map from whole-numbered places to the plane, evaluated at every step-th place (by
/// absolute index, so that any two windows agree) and bicubic, by Lagrange's formula, in between. Each cell
/// of the mesh is held against the map at its centre. Where they differ by more than the tolerance, or the
/// map is not finite, as at a pole, beside an antimeridian or at the rim of a projection's domain, the cell
/// has a mesh of a quarter of the step, or its places are the map's own.
class ProjectionMesh {
 public:
  using Map = std::function<PlanePoint(std::int64_t x, std::int64_t y)>;
  /// By how much a place may be off in x and in y, at a place that the map gives, in the plane's units.
  using Tolerance = std::function<PlanePoint(const PlanePoint& exact)>;
  /// A rectangle of the plane, with its rim.
  struct Box {
    PlanePoint least, most;
  };

  /// REQUIRES: step > 0.
  ProjectionMesh(IndexWindow places, std::int64_t step, double tolerance, Map map);

  /// Of this mesh only places inside `wanted` are asked for. In cells that lie well outside of it, no place
  /// is worked out, and row() gives NaN.
  ProjectionMesh(IndexWindow places, std::int64_t step, const Tolerance& tolerance, Map map,
                 const Box& wanted);

  /// The places of a row. REQUIRES: y is in the window; out.size() == columns of the window.
  void row(std::int64_t y, std::span<PlanePoint> out) const;

 private:
  // The four nodes that a place is interpolated from: the first of them, and their weights.
  struct Stencil {
    std::int64_t first = 0;
    std::array<double, 4> weights{};
  };
  enum class Cell : std::uint8_t { smooth, finer, exact, unwanted };
  Stencil stencil_of(std::int64_t place) const;
  void make_nodes();
  Cell kind_of(std::int64_t cell_x, std::int64_t cell_y, const Tolerance& tolerance, const Box& wanted);
  bool is_beside(std::int64_t cell_x, std::int64_t cell_y, const Box& wanted) const;
  bool is_smooth(std::int64_t cell_x, std::int64_t cell_y, const Tolerance& tolerance) const;

  IndexWindow places_;
  std::int64_t step_;
  Map map_;
  IndexWindow nodes_;  // in units of step
  IndexWindow cells_;  // likewise: cell (i, j) lies north-east of node (i, j)
  std::vector<PlanePoint> points_;
  std::vector<Cell> kinds_;                      // by cell
  std::map<std::size_t, ProjectionMesh> finer_;  // by cell, of those that have one
  std::vector<double> weights_;                  // across, by place between two nodes: step_ of each node's
};

}  // namespace cairn
