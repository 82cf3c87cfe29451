#include "builder/heights/geometric_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "format/simd_clones.h"

namespace cairn {
namespace {

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

// Where a post lies among every 2^levels-th sample of an axis, `scale` being 2^-levels. On a sample, both
// neighbours are that sample, so that a void beyond it is not asked.
struct Between {
  int low = 0;
  int high = 0;
  double fraction = 0;
};

Between between(double at, double scale, int last) {
  const double coarse = at * scale;
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
        scale_(std::ldexp(1.0, -levels)),
        last_((tile.size - 1) >> levels),
        row_(static_cast<std::size_t>(last_) + 1) {
    assert((tile.size - 1) % (1 << levels) == 0);
  }

  // Calls visit(column, error) for each post of a row with a height; the error is NaN in a hole.
  template <class Visit>
  void measure_row(double y, const std::vector<Between>& columns, const float* heights, const Visit& visit) {
    interpolate_row(between(y, scale_, last_));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (std::isnan(heights[c])) continue;
      visit(c, std::abs(at(columns[c]) - static_cast<double>(heights[c])));
    }
  }

  double error_at(double x, double y, float height) {
    const Between column = between(x, scale_, last_);
    const Between row = between(y, scale_, last_);
    const double low = mix(sample(column.low, row.low), sample(column.low, row.high), row.fraction);
    const double high = mix(sample(column.high, row.low), sample(column.high, row.high), row.fraction);
    return std::abs(mix(low, high, column.fraction) - static_cast<double>(height));
  }

  Between column(double x) const { return between(x, scale_, last_); }

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
  double scale_;  // exact, a power of two
  int last_;
  std::vector<double> row_;
};

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

CAIRN_SIMD_CLONES bool are_equal(const std::int32_t* quanta, std::size_t count, double quantum_m,
                                 const float* heights) {
  int differ = 0;  // no early end, so that the loop is one of vectors
  for (std::size_t i = 0; i < count; ++i)
    differ |= quanta[i] * quantum_m != static_cast<double>(heights[i]) ? 1 : 0;
  return differ == 0;
}

// Whether the tile has every post's height to the last bit, a post on each sample.
bool is_copy_of(const HeightTile& tile, double quantum_m, const MeasuredPosts& posts) {
  const auto on_samples = [&](const std::vector<double>& at) {
    if (at.size() != static_cast<std::size_t>(tile.size)) return false;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (at[i] != static_cast<double>(i)) return false;
    }
    return true;
  };
  if (!tile.voids.empty() || !posts.placed.empty() || !on_samples(posts.xs) || !on_samples(posts.ys))
    return false;
  return are_equal(tile.samples.data(), tile.samples.size(), quantum_m, posts.heights.data());
}

void note_in_group(double x, double y, double error, int groups, PostErrors& errors) {
  if (errors.groups.empty())
    errors.groups.assign(static_cast<std::size_t>(groups) * static_cast<std::size_t>(groups), 0);
  const int column = PostErrors::group_of(x, groups);
  const int row = PostErrors::group_of(y, groups);
  float& most = errors.groups[static_cast<std::size_t>(row) * static_cast<std::size_t>(groups) +
                              static_cast<std::size_t>(column)];
  if (error > static_cast<double>(most)) most = std::nextafter(static_cast<float>(error), HUGE_VALF);
}

}  // namespace

std::uint64_t PostCounting::count(const MeasuredPosts& posts) const {
  const auto beyond = std::find_if(posts.xs.begin(), posts.xs.end(), [&](double x) {
    return (x - x0) * scale >= std::min<double>(window.columns - 1, antimeridian);
  });
  const auto inside = static_cast<std::size_t>(beyond - posts.xs.begin());
  std::uint64_t counted = 0;
  for (const double y : posts.ys) {
    const std::size_t sure = (y - y0) * scale < window.rows - 1 ? inside : 0;
    counted += sure;
    for (std::size_t c = sure; c < posts.xs.size(); ++c) counted += counts(posts.xs[c], y) ? 1 : 0;
  }
  return counted;
}

SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels,
                             const MeasuredPosts& posts) {
  return measure(tile, quantum_m, levels, posts, [](double, double, double) {});
}

SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels, const MeasuredPosts& posts,
                             const PostCounting& counting, ErrorStats& stats) {
  return measure(tile, quantum_m, levels, posts, [&](double x, double y, double error) {
    if (counting.counts(x, y)) stats.add(error, [&] { return counting.place(x, y); });
  });
}

SurfaceError measure_own_surface(const HeightTile& tile, double quantum_m, const MeasuredPosts& posts,
                                 const PostCounting& counting, ErrorStats& stats, PostErrors& errors) {
  if (is_copy_of(tile, quantum_m, posts)) {
    stats.add_exact(counting.count(posts));
    return {};
  }
  const int groups = (tile.size - 1) / 2;
  return measure(tile, quantum_m, 0, posts, [&](double x, double y, double error) {
    if (counting.counts(x, y)) stats.add(error, [&] { return counting.place(x, y); });
    if (error > 0) note_in_group(x, y, error, groups, errors);
  });
}

}  // namespace cairn
