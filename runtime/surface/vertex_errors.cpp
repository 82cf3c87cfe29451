#include "runtime/surface/vertex_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "cairn/geodesy.h"
#include "format/bisection_errors.h"
#include "format/rqt_steps.h"

namespace cairn {
namespace {

/// Returns the largest distance of a straight line from the bilinear surface over the diagonal of one cell.
/// It is `from` and `to` at the ends, and d(t) = from + (to − from)t + bend·t(1−t) between them.
float distance_along_diagonal(float from, float to, float bend) {
  const float ends = std::max(std::abs(from), std::abs(to));
  const float rise = to - from;
  if (std::abs(rise) >= std::abs(bend)) return ends;
  const float t = (1 + rise / bend) / 2;
  return std::max(ends, std::abs(from + rise * t + bend * t * (1 - t)));
}

/// Measures diagonals of squares against the tile's bilinear surface, in quanta.
class Diagonals {
 public:
  Diagonals(const HeightTile& heights, bool rising) : heights_(heights), rising_(rising) {}

  /// Returns the error of the diagonal of the square of s cells at (column, row).
  float error(int column, int row, int s) const {
    const bool rises = diagonal_rises(rising_, heights_.size, column, row, s);
    const int first = rises ? row : row + s, step = rises ? 1 : -1;
    const float from = height(column, first),
                slope = (height(column + s, first + step * s) - from) / static_cast<float>(s);
    float worst = 0, before = 0;
    for (int i = 0; i < s; ++i) {
      const int c = column + i, r = first + step * i;
      const float after = height(c + 1, r + step) - (from + slope * static_cast<float>(i + 1));
      // The bend is minus the twist where the diagonal rises, the twist where it falls.
      const float bend = height(c + 1, r) + height(c, r + step) - height(c, r) - height(c + 1, r + step);
      worst = std::max(worst, distance_along_diagonal(before, after, bend));
      before = after;
    }
    return worst;
  }

 private:
  // Relative to the first sample, so that single precision holds the differences.
  float height(int c, int r) const {
    return static_cast<float>(std::int64_t{heights_.at(c, r)} - heights_.samples.front());
  }
  const HeightTile& heights_;
  bool rising_;
};

}  // namespace

std::vector<float> vertex_errors_m(const HeightTile& heights, const TileId& id, double quantum_m,
                                   bool between_samples) {
  const bool rising = root_rises(id);
  std::vector<float> errors = bisection_errors(heights, rising);
  for (float& e : errors) e *= static_cast<float>(quantum_m);
  if (!between_samples) return errors;
  const Diagonals diagonals(heights, rising);
  for (int s = 2; s < heights.size; s *= 2) {
    for (int row = 0; row + s < heights.size; row += s) {
      for (int column = 0; column + s < heights.size; column += s) {
        float& error = errors[static_cast<std::size_t>(row + s / 2) * static_cast<std::size_t>(heights.size) +
                              static_cast<std::size_t>(column + s / 2)];
        error = std::max(error, diagonals.error(column, row, s) * static_cast<float>(quantum_m));
      }
    }
  }
  return errors;
}

double sagitta_of_cell_m(double cell_radians, double highest_m, const Ellipsoid& ellipsoid) {
  return 2 / std::sqrt(3.0) * (largest_curvature_m(ellipsoid) + std::max(0.0, highest_m)) * cell_radians *
         cell_radians / 4;
}

}  // namespace cairn
