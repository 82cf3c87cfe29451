#include "format/rqt_triangulate.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <vector>

#include "format/bisection_errors.h"

namespace cairn {
namespace {

/// The number of tolerances that an error reaches.
class StepCount {
 public:
  StepCount(double tolerance_quanta, int steps) : steps_(steps) {
    for (int k = 0; k < steps; ++k, tolerance_quanta *= 2)
      limits_[static_cast<std::size_t>(k)] = tolerance_quanta;
  }
  int of(float error) const {
    int count = 0;
    while (count < steps_ && static_cast<double>(error) >= limits_[static_cast<std::size_t>(count)]) ++count;
    return count;
  }

 private:
  int steps_;
  std::array<double, kMostRqtSteps> limits_{};
};

}  // namespace

RqtSteps triangulate(const HeightTile& tile, double quantum_m, float tolerance_m, int steps, bool rising) {
  assert(tolerance_m > 0 && steps >= 1 && steps <= kMostRqtSteps);
  const std::vector<float> errors = bisection_errors(tile, rising);
  const StepCount count(static_cast<double>(tolerance_m) / quantum_m, steps);
  RqtSteps result(tile.size, rising);
  for (int row = 0; row < tile.size; ++row) {
    for (int column = 0; column < tile.size; ++column) {
      const float error = errors[static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.size) +
                                 static_cast<std::size_t>(column)];
      if (const int reached = count.of(error); reached > 0) result.raise(column, row, reached);
    }
  }
  return result;
}

}  // namespace cairn
