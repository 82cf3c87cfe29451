#include "runtime/lod/mesh/vertex_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "format/bisection_errors.h"
#include "format/rqt_steps.h"
#include "runtime/geodesy.h"

namespace cairn {
namespace {

/// A quarter of the largest twist of the cells along both diagonals of every square, and what two triangles
/// bisected at each vertex cut: by vertex, row-major.
class Twists {
 public:
  Twists(const HeightTile& heights, double quantum_m, bool rising)
      : size_(heights.size), rising_(rising), of_vertex_(heights.samples.size()) {
    const int cells = size_ - 1;
    rising_m_.resize(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (int r = 0; r < cells; ++r) {
      for (int c = 0; c < cells; ++c) {
        const double twist = static_cast<double>(heights.at(c, r)) - heights.at(c + 1, r) -
                             heights.at(c, r + 1) + heights.at(c + 1, r + 1);
        rising_m_[static_cast<std::size_t>(r) * static_cast<std::size_t>(cells) +
                  static_cast<std::size_t>(c)] = static_cast<float>(std::abs(twist) * quantum_m / 4);
      }
    }
    falling_m_ = rising_m_;
  }

  std::vector<float> run() {
    for (int s = 2; s < size_; s *= 2) level(s);
    return std::move(of_vertex_);
  }

 private:
  float& vertex(int c, int r) {
    return of_vertex_[static_cast<std::size_t>(r) * static_cast<std::size_t>(size_) +
                      static_cast<std::size_t>(c)];
  }

  // rising_m_ and falling_m_ hold the diagonals of the squares of s/2 cells, and then those of s.
  void level(int s) {
    const int h = s / 2, count = (size_ - 1) / s;
    std::vector<float> rising(static_cast<std::size_t>(count) * static_cast<std::size_t>(count));
    std::vector<float> falling(rising.size());
    for (int y = 0; y < count; ++y) {
      for (int x = 0; x < count; ++x) {
        const auto of = [&](const std::vector<float>& diagonals, int i, int j) {
          return diagonals[static_cast<std::size_t>(2 * y + j) * static_cast<std::size_t>(2 * count) +
                           static_cast<std::size_t>(2 * x + i)];
        };
        const float sw = of(rising_m_, 0, 0), ne = of(rising_m_, 1, 1);
        const float se = of(falling_m_, 1, 0), nw = of(falling_m_, 0, 1);
        const std::size_t i =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(count) + static_cast<std::size_t>(x);
        rising[i] = std::max(sw, ne);
        falling[i] = std::max(se, nw);
        const int c = x * s, r = y * s;
        const auto note = [&](int column, int row, float twist) {
          vertex(column, row) = std::max(vertex(column, row), twist);
        };
        note(c + h, r, std::max(sw, se));
        note(c + s, r + h, std::max(se, ne));
        note(c + h, r + s, std::max(nw, ne));
        note(c, r + h, std::max(sw, nw));
        note(c + h, r + h, diagonal_rises(rising_, size_, c, r, s) ? rising[i] : falling[i]);
      }
    }
    rising_m_ = std::move(rising);
    falling_m_ = std::move(falling);
  }

  int size_;
  bool rising_;
  std::vector<float> rising_m_, falling_m_;
  std::vector<float> of_vertex_;
};

}  // namespace

std::vector<float> vertex_errors_m(const HeightTile& heights, const TileId& id, double quantum_m,
                                   bool between_samples) {
  const bool rising = root_rises(id);
  std::vector<float> errors = bisection_errors(heights, rising);
  for (float& e : errors) e *= static_cast<float>(quantum_m);
  if (!between_samples) return errors;
  const std::vector<float> twists = Twists(heights, quantum_m, rising).run();
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] += twists[i];
  return errors;
}

double chord_of_cell_m(double cell_radians, double highest_m) {
  return 2 / std::sqrt(3.0) * (kEquatorialRadius + std::max(0.0, highest_m)) * cell_radians * cell_radians /
         4;
}

}  // namespace cairn
