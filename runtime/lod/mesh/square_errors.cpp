#include "runtime/lod/mesh/square_errors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "format/bisection_errors.h"
#include "format/rqt_steps.h"
#include "runtime/geodesy.h"
#include "runtime/lod/mesh/grid_positions.h"

namespace cairn {
namespace {

constexpr int kMantissaBits = 19;  // of a float's 23, left out: four stay

std::int64_t bits_of(float length) {
  return std::bit_cast<std::int32_t>(length);
}

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

LengthCode::LengthCode(float largest_m)
    : base_((bits_of(std::max(largest_m, 1e-6f)) >> kMantissaBits) - 254) {}

std::uint8_t LengthCode::round_up(float length_m) const {
  if (length_m <= 0) return 0;
  const std::int64_t up = ((bits_of(length_m) + (1 << kMantissaBits) - 1) >> kMantissaBits) - base_;
  return static_cast<std::uint8_t>(std::clamp<std::int64_t>(up, 1, 255));
}

int LengthCode::limit(float length_m) const {
  if (!(length_m >= 0)) return -1;
  const std::int64_t down = (bits_of(length_m) >> kMantissaBits) - base_;
  return static_cast<int>(std::clamp<std::int64_t>(down, 0, 255));
}

SquareErrors::SquareErrors(const LodScene& scene, const LodTile& tile, bool between_samples)
    : levels_(std::bit_width(static_cast<unsigned>(tile.heights->size - 1)) - 1),
      between_samples_(between_samples) {
  const HeightTile& heights = *tile.heights;
  const bool rising = root_rises(tile.source);
  std::vector<float> errors_m = bisection_errors(heights, rising);
  for (float& e : errors_m) e *= static_cast<float>(scene.quantum_m);
  const std::vector<float> twists_m =
      between_samples ? Twists(heights, scene.quantum_m, rising).run() : std::vector<float>();
  const double cell = tile_width_degrees(tile.source.level) / (heights.size - 1) * std::numbers::pi / 180;
  chord_of_cell_m_ = 2 / std::sqrt(3.0) * (kEquatorialRadius + std::max(0.0, tile.max_m)) * cell * cell / 4;
  std::size_t squares = 0;
  for (int k = levels_; k >= 1; --k) {
    first_[static_cast<std::size_t>(k)] = squares;
    squares += std::size_t{1} << (2 * (levels_ - k));
  }
  squares_.resize(squares);
  fill(heights, errors_m, twists_m);
  place_spheres(scene, tile);
}

void SquareErrors::fill(const HeightTile& heights, const std::vector<float>& errors_m,
                        const std::vector<float>& twists_m) {
  const auto error = [&](int c, int r) {
    const std::size_t i =
        static_cast<std::size_t>(r) * static_cast<std::size_t>(heights.size) + static_cast<std::size_t>(c);
    return errors_m[i] + (twists_m.empty() ? 0 : twists_m[i]);
  };
  float largest = 0;
  for (int r = 0; r < heights.size; ++r) {
    for (int c = 0; c < heights.size; ++c) largest = std::max(largest, error(c, r));
  }
  code_ = LengthCode(largest);
  for (int k = 1; k <= levels_; ++k) {
    const int h = 1 << (k - 1);
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        SquareError& square = squares_[slot(k, x, y)];
        const int c = (2 * x + 1) * h, r = (2 * y + 1) * h;
        square.centre = code_.round_up(error(c, r));
        square.middles = {code_.round_up(error(c, r - h)), code_.round_up(error(c + h, r)),
                          code_.round_up(error(c, r + h)), code_.round_up(error(c - h, r))};
        square.below =
            std::max(square.centre, *std::max_element(square.middles.begin(), square.middles.end()));
        for (int q = 0; k > 1 && q < 4; ++q)
          square.below = std::max(square.below, at(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1)).below);
      }
    }
  }
}

void SquareErrors::place_spheres(const LodScene& scene, const LodTile& tile) {
  const HeightTile& heights = *tile.heights;
  const std::int64_t spacing = lattice_width(tile.source.level) / (heights.size - 1);
  const GridPositions positions(south_west_of(tile.source), spacing, heights.size);
  const int least = std::min(kSphereLevel, levels_);
  spheres_.resize(slot(least, (1 << (levels_ - least)) - 1, (1 << (levels_ - least)) - 1) + 1);
  std::vector<std::array<double, 2>> ranges(spheres_.size());
  for (int k = least; k <= levels_; ++k) {
    const int s = 1 << k;
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        auto& [low, high] = ranges[slot(k, x, y)];
        low = HUGE_VAL, high = -HUGE_VAL;
        if (k == least) {
          for (int r = y * s; r <= (y + 1) * s; ++r) {
            for (int c = x * s; c <= (x + 1) * s; ++c) {
              low = std::min(low, heights.at(c, r) * scene.quantum_m);
              high = std::max(high, heights.at(c, r) * scene.quantum_m);
            }
          }
        } else {
          for (int q = 0; q < 4; ++q) {
            const auto& inner = ranges[slot(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1))];
            low = std::min(low, inner[0]);
            high = std::max(high, inner[1]);
          }
        }
        SquareSphere& sphere = spheres_[slot(k, x, y)];
        sphere.centre = positions.at(x * s + s / 2, y * s + s / 2, (low + high) / 2);
        for (int q = 0; q < 4; ++q) {
          for (const double height : {low, high}) {
            const glm::dvec3 corner = positions.at((x + (q & 1)) * s, (y + (q >> 1)) * s, height);
            sphere.radius_m = std::max(sphere.radius_m, glm::length(corner - sphere.centre));
          }
        }
        sphere.radius_m += chord_m(k);
      }
    }
  }
}

const SquareSphere& SquareErrors::sphere(int k, int x, int y) const {
  const int up = std::max(0, std::min(kSphereLevel, levels_) - k);
  return spheres_[slot(k + up, x >> up, y >> up)];
}

std::uint64_t SquareErrors::bytes() const {
  return squares_.size() * sizeof(SquareError) + spheres_.size() * sizeof(SquareSphere);
}

}  // namespace cairn
