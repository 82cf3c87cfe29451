#include "format/bisection_errors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "format/rqt_steps.h"

namespace cairn {
namespace {

struct Corner {
  int column = 0;
  int row = 0;
};

/// h = at_origin + east·column + north·row.
struct Plane {
  float at_origin = 0;
  float east = 0;
  float north = 0;
};

class Meter {
 public:
  Meter(const HeightTile& tile, bool rising)
      : size_(tile.size), last_(tile.size - 1), rising_(rising), heights_(tile.samples.size()) {
    // From the lowest, so that single precision holds what differs.
    const std::int64_t base = *std::min_element(tile.samples.begin(), tile.samples.end());
    std::transform(tile.samples.begin(), tile.samples.end(), heights_.begin(),
                   [base](std::int32_t h) { return static_cast<float>(h - base); });
    errors_.resize(heights_.size());
  }

  std::vector<float> run() {
    measure_finest();
    for (int s = 4; s <= last_; s *= 2) {
      for (int row = 0; row < last_; row += s) {
        for (int column = 0; column < last_; column += s) measure_square(column, row, s);
      }
    }
    return std::move(errors_);
  }

 private:
  std::ptrdiff_t index(int column, int row) const {
    return static_cast<std::ptrdiff_t>(row) * size_ + column;
  }
  float height(int column, int row) const { return heights_[static_cast<std::size_t>(index(column, row))]; }
  void note(int column, int row, float error) {
    float& worst = errors_[static_cast<std::size_t>(index(column, row))];
    worst = std::max(worst, error);
  }
  float off_middle(int column, int row, int dc, int dr) const {
    return std::abs(height(column, row) -
                    (height(column - dc, row - dr) + height(column + dc, row + dr)) * 0.5f);
  }

  // Squares of two cells: their quarters cover no sample but their corners and bases, their halves also the
  // middles of two edges.
  void measure_finest() {
    for (int row = 0; row <= last_; row += 2) {
      for (int column = 1; column < last_; column += 2) note(column, row, off_middle(column, row, 1, 0));
    }
    for (int row = 1; row < last_; row += 2) {
      for (int column = 0; column <= last_; column += 2) note(column, row, off_middle(column, row, 0, 1));
    }
    for (int row = 1; row < last_; row += 2) {
      for (int column = 1; column < last_; column += 2) {
        const float across = diagonal_rises(rising_, size_, column - 1, row - 1, 2)
                                 ? off_middle(column, row, 1, 1)
                                 : off_middle(column, row, 1, -1);
        const auto at = [&](int c, int r) { return errors_[static_cast<std::size_t>(index(c, r))]; };
        note(column, row,
             std::max({across, at(column - 1, row), at(column + 1, row), at(column, row - 1),
                       at(column, row + 1)}));
      }
    }
  }

  void measure_square(int column, int row, int s) {
    const int h = s / 2;
    note(column + h, row, south_quarter(column, row, s));
    note(column + h, row + s, north_quarter(column, row, s));
    note(column, row + h, west_quarter(column, row, s));
    note(column + s, row + h, east_quarter(column, row, s));
    const bool rises = diagonal_rises(rising_, size_, column, row, s);
    note(column + h, row + h,
         rises ? std::max(half(column, row, s, true, false), half(column, row, s, false, true))
               : std::max(half(column, row, s, true, true), half(column, row, s, false, false)));
  }

  // A plane through the ends of a row and a third height `rise` above (or below) their middle, `rows` away.
  Plane over_row(int column, int row, int s, float apex, int apex_row) const {
    const float west = height(column, row), east = height(column + s, row);
    Plane plane;
    plane.east = (east - west) / static_cast<float>(s);
    plane.north = (apex - (west + east) * 0.5f) / static_cast<float>(apex_row - row);
    plane.at_origin = west;
    return plane;
  }
  Plane over_column(int column, int row, int s, float apex, int apex_column) const {
    const float south = height(column, row), north = height(column, row + s);
    Plane plane;
    plane.north = (north - south) / static_cast<float>(s);
    plane.east = (apex - (south + north) * 0.5f) / static_cast<float>(apex_column - column);
    plane.at_origin = south;
    return plane;
  }

  float south_quarter(int column, int row, int s) const {
    const int h = s / 2;
    const Plane plane = over_row(column, row, s, height(column + h, row + h), row + h);
    float worst = 0;
    for (int i = 0; i < h; ++i)
      worst = std::max(worst, row_error(plane, {column, row}, row + i, column + i, column + s - i));
    return worst;
  }
  float north_quarter(int column, int row, int s) const {
    const int h = s / 2;
    const Plane plane = over_row(column, row + s, s, height(column + h, row + h), row + h);
    float worst = 0;
    for (int i = 0; i < h; ++i)
      worst = std::max(worst, row_error(plane, {column, row + s}, row + s - i, column + i, column + s - i));
    return worst;
  }
  float west_quarter(int column, int row, int s) const {
    const int h = s / 2;
    const Plane plane = over_column(column, row, s, height(column + h, row + h), column + h);
    float worst = 0;
    for (int i = 1; i < s; ++i)
      worst = std::max(worst, row_error(plane, {column, row}, row + i, column, column + std::min(i, s - i)));
    return worst;
  }
  float east_quarter(int column, int row, int s) const {
    const int h = s / 2;
    const Plane plane = over_column(column + s, row, s, height(column + h, row + h), column + h);
    float worst = 0;
    for (int i = 1; i < s; ++i) {
      const int first = column + s - std::min(i, s - i);
      worst = std::max(worst, row_error(plane, {column + s, row}, row + i, first, column + s));
    }
    return worst;
  }

  // The half of a square with its right angle in the named corner.
  float half(int column, int row, int s, bool east, bool north) const {
    const Corner apex{east ? column + s : column, north ? row + s : row};
    const float at_apex = height(apex.column, apex.row);
    const float along = height(east ? column : column + s, apex.row);
    const float up = height(apex.column, north ? row : row + s);
    const float step = 1 / static_cast<float>(s);
    const Plane plane{at_apex, (east ? at_apex - along : along - at_apex) * step,
                      (north ? at_apex - up : up - at_apex) * step};
    float worst = 0;
    for (int i = 0; i < s; ++i) {
      const int r = north ? row + s - i : row + i;
      worst = std::max(
          worst, row_error(plane, apex, r, east ? column + i : column, east ? column + s : column + s - i));
    }
    return worst;
  }

  // The largest distance over a row's samples first … last from a plane given from `origin` on.
  float row_error(const Plane& plane, Corner origin, int row, int first, int last) const {
    const float* samples = heights_.data() + index(first, row);
    const float start = plane.at_origin + plane.north * static_cast<float>(row - origin.row) +
                        plane.east * static_cast<float>(first - origin.column);
    // Eight chains, so that the compiler may use wide registers: the largest is the same in any order.
    constexpr int kChains = 8;
    std::array<float, kChains> worst{};
    const int count = last - first + 1;
    int i = 0;
    for (; i + kChains <= count; i += kChains) {
      for (int k = 0; k < kChains; ++k) {
        const float error = std::abs(samples[i + k] - (start + plane.east * static_cast<float>(i + k)));
        worst[static_cast<std::size_t>(k)] =
            error > worst[static_cast<std::size_t>(k)] ? error : worst[static_cast<std::size_t>(k)];
      }
    }
    for (; i < count; ++i)
      worst[0] = std::max(worst[0], std::abs(samples[i] - (start + plane.east * static_cast<float>(i))));
    return *std::max_element(worst.begin(), worst.end());
  }

  int size_;
  int last_;
  bool rising_;
  std::vector<float> heights_;
  std::vector<float> errors_;
};

}  // namespace

std::vector<float> bisection_errors(const HeightTile& tile, bool rising) {
  assert(tile.size >= 3 && ((tile.size - 1) & (tile.size - 2)) == 0);
  return Meter(tile, rising).run();
}

}  // namespace cairn
