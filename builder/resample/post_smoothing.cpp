#include "builder/resample/post_smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "format/simd_clones.h"

namespace cairn {
namespace {

// Savitzky & Golay's five points for a quadratic are (-3 12 17 12 -3)/35: the middle one, and these of the
// second differences at distance 1 and 2. So equal posts stay equal whatever the rounding.
constexpr double kNear = 12.0 / 35;
constexpr double kFar = -3.0 / 35;

// What smoothing adds to v[0], whose neighbours along the axis lie `step` numbers apart.
template <class T>
inline double smoothing_of(const T* v, std::ptrdiff_t step) {
  const auto at = [&](std::ptrdiff_t k) { return static_cast<double>(v[k * step]); };
  return kNear * (at(-1) - at(0) + (at(1) - at(0))) + kFar * (at(-2) - at(0) + (at(2) - at(0)));
}

CAIRN_SIMD_CLONES void find_smoothing_across(const float* row, std::ptrdiff_t stride, std::size_t count,
                                             double* change) {
  for (std::size_t c = 0; c < count; ++c) change[c] = smoothing_of(row + c, stride);
}

CAIRN_SIMD_CLONES void add_smoothing_along(const double* row, std::size_t count, double* change) {
  for (std::size_t c = 0; c < count; ++c) change[c] += smoothing_of(row + c, 1);
}

CAIRN_SIMD_CLONES void add_rows(const float* row, const double* change, std::size_t count, double* sums) {
  for (std::size_t c = 0; c < count; ++c) sums[c] = static_cast<double>(row[c]) + change[c];
}

// Tukey's biweight (Beaton & Tukey 1974): a change of `most` or more is relief, and is not made.
CAIRN_SIMD_CLONES void add_small_changes(const float* row, const double* change, const std::uint8_t* level,
                                         std::size_t count, double most, float* heights) {
  const double scale = most > 0 ? 1 / (most * most) : std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < count; ++c) {
    const double rest = 1 - change[c] * change[c] * scale;
    const double share = (rest > 0 ? rest : 0) * (level[c] == 0 ? 1 : 0);
    heights[c] = static_cast<float>(static_cast<double>(row[c]) + change[c] * share * share);
  }
}

// Of each post, whether its neighbours in the column are as high as it.
CAIRN_SIMD_CLONES void mark_equal_across(const float* row, std::ptrdiff_t stride, std::size_t count,
                                         std::uint8_t* equal) {
  const float* south = row - stride;
  const float* north = row + stride;
  for (std::size_t c = 0; c < count; ++c) equal[c] = south[c] == row[c] && north[c] == row[c] ? 1 : 0;
}

// Of each post, whether its neighbours along the row are as high as it, and all three as their neighbours in
// the column. The first and the last are not.
CAIRN_SIMD_CLONES void mark_equal_along(const float* row, const std::uint8_t* equal_across, std::size_t count,
                                        std::uint8_t* level) {
  level[0] = level[count - 1] = 0;
  for (std::size_t c = 1; c + 1 < count; ++c) {
    const int along = row[c - 1] == row[c] && row[c + 1] == row[c] ? 1 : 0;
    level[c] = static_cast<std::uint8_t>(along & equal_across[c - 1] & equal_across[c] & equal_across[c + 1]);
  }
}

CAIRN_SIMD_CLONES void mark_also(const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
  for (std::size_t c = 0; c < count; ++c) to[c] |= from[c];
}

inline float smaller_step(const float* post, std::ptrdiff_t step) {
  return std::min(std::abs(post[-step] - post[0]), std::abs(post[step] - post[0]));
}

// Neighbours lie `along` and `across` numbers apart; 0 stands for none.
CAIRN_SIMD_CLONES void find_bounds(const float* row, std::ptrdiff_t along, std::ptrdiff_t across,
                                   const std::uint8_t* level, std::size_t count, float beyond, float* lowest,
                                   float* highest) {
  for (std::size_t c = 0; c < count; ++c) {
    const float step = std::max(smaller_step(row + c, along), smaller_step(row + c, across));
    const float slack = (0.5F * step + beyond) * (level[c] == 0 ? 1.0F : 0.0F);
    lowest[c] = row[c] - slack;
    highest[c] = row[c] + slack;
  }
}

}  // namespace

PostSmoothing::PostSmoothing(const SmoothAxis& x, const SmoothAxis& y, const SmoothTolerance& tolerance,
                             std::span<const float> posts)
    : x_(x), y_(y), tolerance_(tolerance), posts_(posts) {}

const float* PostSmoothing::post(std::int64_t i, std::int64_t j) const {
  return posts_.data() + (j - y_.posts.first) * x_.posts.count() + (i - x_.posts.first);
}

SmoothedPosts PostSmoothing::smooth(IndexRange columns) {
  columns_ = columns;
  around_ = x_.posts_around(columns);
  find_level();
  const std::int64_t rows = y_.smoothed.count();
  const SmoothedPosts to{columns, heights_.shape(rows, columns.count()), lowest_.shape(rows, columns.count()),
                         highest_.shape(rows, columns.count())};
  for (std::int64_t r = 0; r < rows; ++r) {
    smooth_row(y_.smoothed.first + r, to.heights.row(r));
    bound_row(y_.smoothed.first + r, to.lowest.row(r), to.highest.row(r));
  }
  return to;
}

// Marks the posts of level ground: those with neighbours of equal height all around, and these neighbours.
// Along a pinned line only neighbours on the line count.
void PostSmoothing::find_level() {
  const std::int64_t rows = y_.posts.count();
  const std::int64_t columns = around_.count();
  const Rows<std::uint8_t> equal = equal_.shape(rows, columns);
  mark_equal(equal);
  level_ = level_rows_.shape(rows, columns);
  for (std::int64_t r = 0; r < rows; ++r) {
    const std::uint8_t* e = equal.row(r);
    const float* p = post(around_.first, y_.posts.first + r);
    mark_equal_along(p, e, static_cast<std::size_t>(columns), level_.row(r));
    for (std::int64_t c = 0; c < columns; ++c) {
      if (x_.is_pinned(around_.first + c)) level_.row(r)[c] = e[c];
    }
  }
  spread_along_rows();
  spread_across_rows();
}

// Whether a post is as high as its neighbours in the column.
void PostSmoothing::mark_equal(Rows<std::uint8_t> equal) const {
  const auto columns = static_cast<std::size_t>(around_.count());
  for (std::int64_t j = y_.posts.first; j <= y_.posts.last; ++j) {
    std::uint8_t* e = equal.row(j - y_.posts.first);
    if (y_.is_pinned(j)) {
      std::fill_n(e, columns, std::uint8_t{1});
    } else if (j == y_.posts.first || j == y_.posts.last) {
      std::fill_n(e, columns, std::uint8_t{0});
    } else {
      mark_equal_across(post(around_.first, j), x_.posts.count(), columns, e);
    }
  }
}

// Marks the neighbours of marked posts along x, and then along y, pinned lines aside.
void PostSmoothing::spread_along_rows() {
  const auto columns = static_cast<std::size_t>(around_.count());
  for (std::int64_t r = 0; r < y_.posts.count(); ++r) {
    const Rows<std::uint8_t> from = unspread_.shape(1, around_.count());
    std::uint8_t* to = level_.row(r);
    std::copy_n(to, columns, from.data);
    for (std::size_t c = 0; c < columns; ++c) {
      const std::int64_t i = around_.first + static_cast<std::int64_t>(c);
      if (x_.is_pinned(i)) continue;
      if (c > 0 && !x_.is_pinned(i - 1)) to[c] |= from.data[c - 1];
      if (c + 1 < columns && !x_.is_pinned(i + 1)) to[c] |= from.data[c + 1];
    }
  }
}

void PostSmoothing::spread_across_rows() {
  const auto columns = static_cast<std::size_t>(around_.count());
  const Rows<std::uint8_t> from = unspread_.shape(y_.posts.count(), around_.count());
  std::copy_n(level_.data, y_.posts.count() * around_.count(), from.data);
  for (std::int64_t j = y_.posts.first; j <= y_.posts.last; ++j) {
    if (y_.is_pinned(j)) continue;
    for (const std::int64_t other : {j - 1, j + 1}) {
      if (!y_.posts.holds(other) || y_.is_pinned(other)) continue;
      mark_also(from.row(other - y_.posts.first), columns, level_.row(j - y_.posts.first));
    }
  }
}

void PostSmoothing::smooth_row(std::int64_t j, float* heights) {
  const auto wide = static_cast<std::size_t>(around_.count());
  change_.assign(wide, 0);
  sums_.resize(wide);
  const float* row = post(around_.first, j);
  if (!y_.is_pinned(j)) find_smoothing_across(row, x_.posts.count(), wide, change_.data());
  add_rows(row, change_.data(), wide, sums_.data());

  const std::ptrdiff_t from = columns_.first - around_.first;
  double* change = change_.data() + from;
  std::int64_t begin = 0;
  for (std::int64_t c = 0; c <= columns_.count(); ++c) {
    if (c < columns_.count() && !x_.is_pinned(columns_.first + c)) continue;
    add_smoothing_along(sums_.data() + from + begin, static_cast<std::size_t>(c - begin), change + begin);
    begin = c + 1;
  }
  add_small_changes(row + from, change, level_.row(j - y_.posts.first) + from,
                    static_cast<std::size_t>(columns_.count()), 4 * tolerance_.interval_m, heights);
}

void PostSmoothing::bound_row(std::int64_t j, float* lowest, float* highest) const {
  const auto count = static_cast<std::size_t>(columns_.count());
  const float* row = post(columns_.first, j);
  const std::uint8_t* level = level_.row(j - y_.posts.first) + (columns_.first - around_.first);
  const auto beyond = static_cast<float>(2 * tolerance_.overshoot_m);
  const std::ptrdiff_t across = y_.is_pinned(j) ? 0 : x_.posts.count();
  std::size_t begin = 0;
  for (std::size_t c = 0; c <= count; ++c) {
    const bool pinned = c < count && x_.is_pinned(columns_.first + static_cast<std::int64_t>(c));
    if (c < count && !pinned) continue;
    find_bounds(row + begin, 1, across, level + begin, c - begin, beyond, lowest + begin, highest + begin);
    if (pinned) find_bounds(row + c, 0, across, level + c, 1, beyond, lowest + c, highest + c);
    begin = c + 1;
  }
}

}  // namespace cairn
