#include "builder/geometric_error.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace cairn {
namespace {

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

// Where a post lies among every 2^levels-th sample of an axis. On a sample, both neighbours are that sample,
// so that a void beyond it is not asked.
struct Between {
  int low = 0;
  int high = 0;
  double fraction = 0;
};

Between between(double at, int levels, int last) {
  const double coarse = std::ldexp(at, -levels);
  const int low = std::min(static_cast<int>(coarse), last);
  const double fraction = coarse - low;
  return {low, fraction == 0 ? low : low + 1, fraction};
}

class SurfaceMeter {
 public:
  SurfaceMeter(const HeightTile& tile, double quantum_m, int levels)
      : tile_(tile),
        quantum_m_(quantum_m),
        levels_(levels),
        last_((tile.size - 1) >> levels),
        row_(static_cast<std::size_t>(last_) + 1) {
    assert((tile.size - 1) % (1 << levels) == 0);
  }

  // Calls visit(column, error) for each post of a row with a height; the error is NaN in a hole.
  template <class Visit>
  void measure_row(double y, const std::vector<Between>& columns, const float* heights, const Visit& visit) {
    interpolate_row(between(y, levels_, last_));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (std::isnan(heights[c])) continue;
      visit(c, std::abs(at(columns[c]) - static_cast<double>(heights[c])));
    }
  }

  // The largest error of a row's posts, where the tile has no voids; NaN heights count for nothing.
  double worst_of_row(double y, const std::vector<Between>& columns, const float* heights) {
    interpolate_row(between(y, levels_, last_));
    // Four chains, so that one comparison need not wait for the last.
    std::array<double, 4> worst{};
    const auto note = [&](std::size_t c, double& chain) {
      const double error = std::abs(at(columns[c]) - static_cast<double>(heights[c]));
      chain = error > chain ? error : chain;
    };
    std::size_t c = 0;
    for (; c + worst.size() <= columns.size(); c += worst.size()) {
      for (std::size_t k = 0; k < worst.size(); ++k) note(c + k, worst[k]);
    }
    for (; c < columns.size(); ++c) note(c, worst[0]);
    return *std::max_element(worst.begin(), worst.end());
  }

  double error_at(double x, double y, float height) {
    const Between column = between(x, levels_, last_);
    const Between row = between(y, levels_, last_);
    const double low = mix(sample(column.low, row.low), sample(column.low, row.high), row.fraction);
    const double high = mix(sample(column.high, row.low), sample(column.high, row.high), row.fraction);
    return std::abs(mix(low, high, column.fraction) - static_cast<double>(height));
  }

  Between column(double x) const { return between(x, levels_, last_); }

 private:
  static double mix(double a, double b, double fraction) { return a + fraction * (b - a); }

  double sample(int c, int r) const {
    const int column = c << levels_;
    const int row = r << levels_;
    return tile_.is_void(column, row) ? kHole : tile_.at(column, row) * quantum_m_;
  }

  double at(const Between& b) const {
    return mix(row_[static_cast<std::size_t>(b.low)], row_[static_cast<std::size_t>(b.high)], b.fraction);
  }

  void interpolate_row(const Between& b) {
    const int step = 1 << levels_;
    const auto size = static_cast<std::size_t>(tile_.size);
    const std::size_t low = (static_cast<std::size_t>(b.low) << levels_) * size;
    const std::size_t high = (static_cast<std::size_t>(b.high) << levels_) * size;
    for (std::size_t c = 0, k = 0; k < row_.size(); c += static_cast<std::size_t>(step), ++k) {
      row_[k] = mix(tile_.samples[low + c], tile_.samples[high + c], b.fraction) * quantum_m_;
    }
    if (tile_.voids.empty()) return;
    for (std::size_t c = 0, k = 0; k < row_.size(); c += static_cast<std::size_t>(step), ++k) {
      if (tile_.voids[low + c] != 0 || tile_.voids[high + c] != 0) row_[k] = kHole;
    }
  }

  const HeightTile& tile_;
  double quantum_m_;
  int levels_;
  int last_;
  std::vector<double> row_;
};

SurfaceError measure_rows(const HeightTile& tile, double quantum_m, int levels, const MeasuredPosts& posts) {
  SurfaceMeter meter(tile, quantum_m, levels);
  std::vector<Between> columns;
  for (const double x : posts.xs) columns.push_back(meter.column(x));
  SurfaceError result;
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    const float* heights = posts.heights.data() + r * columns.size();
    result.max_m = std::max(result.max_m, meter.worst_of_row(posts.ys[r], columns, heights));
  }
  return result;
}

template <class Visit>
SurfaceError measure(const HeightTile& tile, double quantum_m, int levels, const MeasuredPosts& posts,
                     const Visit& visit) {
  SurfaceMeter meter(tile, quantum_m, levels);
  SurfaceError result;
  const auto note = [&](double x, double y, double error) {
    if (error > result.max_m) result.max_m = error;
    if (std::isnan(error)) {
      result.has_holes = true;
    } else {
      visit(x, y, error);
    }
  };
  std::vector<Between> columns;
  for (const double x : posts.xs) columns.push_back(meter.column(x));
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    const double y = posts.ys[r];
    meter.measure_row(y, columns, posts.heights.data() + r * columns.size(),
                      [&](std::size_t c, double error) { note(posts.xs[c], y, error); });
  }
  for (const auto& p : posts.placed) note(p.x, p.y, meter.error_at(p.x, p.y, p.height));
  return result;
}

}  // namespace

SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels,
                             const MeasuredPosts& posts) {
  if (tile.voids.empty() && posts.placed.empty()) return measure_rows(tile, quantum_m, levels, posts);
  return measure(tile, quantum_m, levels, posts, [](double, double, double) {});
}

SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels, const MeasuredPosts& posts,
                             const PostCounting& counting, PostStats& stats) {
  return measure(tile, quantum_m, levels, posts, [&](double x, double y, double error) {
    if (counting.counts(x, y)) stats.add(error, [&] { return counting.place(x, y); });
  });
}

}  // namespace cairn
