#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/body.h"
#include "runtime/view/sample_lattice.h"

namespace cairn {

/// Geocentric positions of the samples of a square grid, to within some nanometres.
/// The sines and cosines of each column and row are worked out once.
class GridPositions {
 public:
  /// The grid has `side` columns and rows, from the corner to the east and the north, `spacing` lattice units
  /// apart.
  GridPositions(const LatticePoint& corner, std::int64_t spacing, int side, const Ellipsoid& ellipsoid);

  glm::dvec3 at(int column, int row, double height_m) const {
    const Row& r = rows_[static_cast<std::size_t>(row)];
    const Column& c = columns_[static_cast<std::size_t>(column)];
    const double across = (r.normal + height_m) * r.cosine;
    return {across * c.cosine, across * c.sine, (r.polar_normal + height_m) * r.sine};
  }

  /// Returns the ellipsoid's unit normal.
  glm::dvec3 up_at(int column, int row) const {
    const Row& r = rows_[static_cast<std::size_t>(row)];
    const Column& c = columns_[static_cast<std::size_t>(column)];
    return {r.cosine * c.cosine, r.cosine * c.sine, r.sine};
  }

  struct Column {
    double cosine, sine;
  };
  struct Row {
    double cosine, sine;
    double normal;        ///< radius of curvature in the prime vertical, metres
    double polar_normal;  ///< normal · (b/a)²
  };
  std::span<const Column> columns() const { return columns_; }
  std::span<const Row> rows() const { return rows_; }

  std::uint64_t bytes() const { return columns_.size() * sizeof(Column) + rows_.size() * sizeof(Row); }

 private:
  std::vector<Column> columns_;
  std::vector<Row> rows_;
};

}  // namespace cairn
