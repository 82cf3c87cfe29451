#pragma once

#include <cstdint>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// In how many of a tile's nested triangulations each sample is a vertex.
///
/// Triangulation k = 0, 1, 2 … is off the tile's samples by less than tolerance_m(k), and part of the one
/// before: a restricted quadtree triangulation (Pajarola 1998; Intel 2012, "Adaptive Triangulation"), whose
/// hierarchy is that of RqtSteps. A sample is in a triangulation where the triangles that it bisects are off
/// by that much, or where a vertex that needs it is in it. So every square of the hierarchy, taken alone, has
/// a triangulation at each step, and any superset of its vertices that holds what they need keeps the
/// tolerance too. About 10 ms a tile of 513 samples, once when it is loaded; 290 KB.
class VertexSteps {
 public:
  /// Tolerances grow by this root of 2: a finer series draws fewer triangles, and changes them more often.
  static constexpr int kPerOctave = 3;
  /// The step whose triangulation has every sample.
  static constexpr int kAll = -1;

  VertexSteps() = default;
  /// `between_samples`: all places of the tile's bilinear surface count, see vertex_errors_m().
  VertexSteps(const HeightTile& heights, const TileId& id, double quantum_m, bool between_samples);

  static double tolerance_m(int step);
  /// The coarsest step whose tolerance is within this; kAll where none is.
  static int step_within(double allowed_m);

  bool has(int column, int row, int step) const { return row_of(row)[column] > step; }
  /// The codes of a row; a sample is in the triangulation where its code is above the step.
  const std::uint8_t* row_of(int row) const {
    return &codes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(size_)];
  }

  /// Which samples along a line from (column, row) are vertices: bit i is that of the i-th, 0 < i < cells.
  /// REQUIRES: cells <= 64, the line within the tile.
  std::uint64_t along_row(int column, int row, int cells, int step) const;
  std::uint64_t along_column(int column, int row, int cells, int step) const;

  std::uint64_t bytes() const { return codes_.size() + columns_.size(); }

 private:
  int size_ = 0;
  std::vector<std::uint8_t> codes_;    // row-major from the south-west, then eight more
  std::vector<std::uint8_t> columns_;  // every kColumnStep-th column, likewise: a patch's sides lie there
};

}  // namespace cairn
