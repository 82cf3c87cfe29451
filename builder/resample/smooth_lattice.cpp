#include "builder/resample/smooth_lattice.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <utility>
#include <vector>

#include "builder/resample/row_passes.h"
#include "builder/resample/run_block.h"
#include "format/simd_clones.h"

namespace cairn {
namespace {

// What of post - surface lies beyond the interval.
CAIRN_SIMD_CLONES bool find_beyond(const float* posts, const double* surface, std::size_t count,
                                   double interval_m, double* beyond) {
  int any = 0;  // no early end, so that the loop is one of vectors
  for (std::size_t c = 0; c < count; ++c) {
    const double r = static_cast<double>(posts[c]) - surface[c];
    const double over = r > interval_m ? r - interval_m : 0;
    const double under = r < -interval_m ? r + interval_m : 0;
    beyond[c] = over + under;
    any |= beyond[c] != 0 ? 1 : 0;
  }
  return any != 0;
}

CAIRN_SIMD_CLONES void add_row(const double* row, std::size_t count, double* to) {
  for (std::size_t c = 0; c < count; ++c) to[c] += row[c];
}

CAIRN_SIMD_CLONES void round_row(const double* row, std::size_t count, float* to) {
  for (std::size_t c = 0; c < count; ++c) to[c] = static_cast<float>(row[c]);
}

// The columns of posts to both sides of a sample, or twice the one that it lies on.
struct CellColumns {
  std::int32_t first;
  std::int32_t last;
};

void widen(std::span<const CellColumns> cells, const float* lowest, const float* highest, float* to_lowest,
           float* to_highest) {
  for (std::size_t k = 0; k < cells.size(); ++k) {
    to_lowest[k] = std::min(lowest[cells[k].first], lowest[cells[k].last]);
    to_highest[k] = std::max(highest[cells[k].first], highest[cells[k].last]);
  }
}

struct BoundRows {
  const float* lowest[2];
  const float* highest[2];
};

CAIRN_SIMD_CLONES bool any_overshoots(const double* heights, const BoundRows& bounds, std::size_t count,
                                      double by_m) {
  int any = 0;  // no early end, so that the loop is one of vectors
  for (std::size_t c = 0; c < count; ++c) {
    const float low = std::min(bounds.lowest[0][c], bounds.lowest[1][c]);
    const float high = std::max(bounds.highest[0][c], bounds.highest[1][c]);
    any |= static_cast<double>(low) - heights[c] > by_m ? 1 : 0;
    any |= heights[c] - static_cast<double>(high) > by_m ? 1 : 0;
  }
  return any != 0;
}

bool is_constant(std::span<const float> posts) {
  return std::all_of(posts.begin(), posts.end(), [&](float h) { return h == posts.front(); });
}

// The window's samples, a strip of columns at a time.
class SmoothWindow {
 public:
  SmoothWindow(const SmoothAxis& x, const SmoothAxis& y, const SmoothTolerance& tolerance,
               std::span<const float> posts, IndexWindow window, std::span<float> out)
      : x_(x),
        y_(y),
        tolerance_(tolerance),
        posts_(posts),
        window_(window),
        out_(out),
        smoothing_(x, y, tolerance, posts) {}

  void run() {
    std::size_t first = 0;
    while (first < x_.groups.size()) {
      std::size_t end = first + 1;
      while (end < x_.groups.size() &&
             x_.groups[end].samples.last - x_.groups[first].samples.first < kStripColumns) {
        ++end;
      }
      solve_strip(std::span(x_.groups).subspan(first, end - first));
      first = end;
    }
  }

 private:
  void solve_strip(std::span<const SmoothAxis::Group> groups) {
    groups_ = groups;
    columns_ = {groups.front().samples.first, groups.back().samples.last};
    corrected_ = {};
    for (const auto& group : groups) {
      if (group.posts.count() <= 0) continue;
      if (corrected_.count() <= 0) corrected_ = group.posts;
      corrected_.last = group.posts.last;
    }
    smoothed_ = smoothing_.smooth(posts_of(guess_rows()));
    guess();
    find_corrections();
    combine();
    bound();
    write();
  }

  std::span<const AxisWeights::Row> guess_rows() const {
    return std::span(x_.guess.rows)
        .subspan(static_cast<std::size_t>(columns_.first - x_.samples.first),
                 static_cast<std::size_t>(columns_.count()));
  }

  // The first guess along x, at the samples and at the posts to be corrected, for each row of posts.
  void guess() {
    const IndexRange taps = smoothed_.columns;
    const std::int64_t down = y_.smoothed.count();
    const Rows<double> turned = turned_.shape(taps.count(), down);
    transpose(read(smoothed_.heights), down, taps.count(), turned);

    const Rows<double> along = along_.shape(columns_.count(), down);
    for (std::int64_t k = 0; k < columns_.count(); ++k)
      sum(x_.guess, x_.guess_row(columns_.first + k), read(turned), taps.first, along.row(k), down);
    guess_ = guess_rows_.shape(down, columns_.count());
    transpose(read(along), columns_.count(), down, guess_);

    const std::int64_t count = std::max<std::int64_t>(corrected_.count(), 0);
    const Rows<double> at_posts = along_.shape(count, down);
    for (std::int64_t i = 0; i < count; ++i)
      sum(x_.guess_at_posts, x_.post_row(corrected_.first + i), read(turned), taps.first, at_posts.row(i),
          down);
    at_posts_ = at_posts_rows_.shape(down, count);
    transpose(read(at_posts), count, down, at_posts_);
  }

  // What the guess misses the posts by, made up for along x, for each row of corrected posts.
  void find_corrections() {
    const auto count = static_cast<std::size_t>(std::max<std::int64_t>(corrected_.count(), 0));
    const std::int64_t down = std::max<std::int64_t>(y_.corrected.count(), 0);
    const Rows<double> beyond = beyond_.shape(down, static_cast<std::ptrdiff_t>(count));
    row_is_off_.assign(static_cast<std::size_t>(down), 0);
    surface_.resize(count);
    bool any = false;
    for (std::int64_t j = 0; j < down && count > 0; ++j) {
      const std::int64_t post = y_.corrected.first + j;
      sum(y_.guess_at_posts, y_.post_row(post), read(at_posts_), y_.smoothed.first, surface_.data(),
          static_cast<std::int64_t>(count));
      const float* row =
          posts_.data() + (post - y_.posts.first) * x_.posts.count() + (corrected_.first - x_.posts.first);
      const bool off = find_beyond(row, surface_.data(), count, tolerance_.interval_m, beyond.row(j));
      row_is_off_[static_cast<std::size_t>(j)] = off ? 1 : 0;
      any = any || off;
    }
    corrections_ = corrections_rows_.shape(any ? down : 0, columns_.count());
    if (!any) return;
    const Rows<double> turned = turned_.shape(static_cast<std::ptrdiff_t>(count), down);
    transpose(read(beyond), down, static_cast<std::ptrdiff_t>(count), turned);
    const Rows<double> along = along_.shape(columns_.count(), down);
    for (std::int64_t k = 0; k < columns_.count(); ++k) {
      sum(x_.correction, x_.correction_row(columns_.first + k), read(turned), corrected_.first, along.row(k),
          down);
    }
    transpose(read(along), columns_.count(), down, corrections_);
  }

  // Guess and corrections, along y.
  void combine() {
    heights_ = heights_rows_.shape(y_.samples.count(), columns_.count());
    surface_.resize(static_cast<std::size_t>(columns_.count()));
    for (std::int64_t l = 0; l < y_.samples.count(); ++l) {
      const std::int64_t sample = y_.samples.first + l;
      sum(y_.guess, y_.guess_row(sample), read(guess_), y_.smoothed.first, heights_.row(l), columns_.count());
      const AxisWeights::Row& row = y_.correction_row(sample);
      const auto off = row_is_off_.begin() + (row.count > 0 ? row.first - y_.corrected.first : 0);
      if (std::find(off, off + row.count, 1) == off + row.count) continue;
      sum(y_.correction, row, read(corrections_), y_.corrected.first, surface_.data(), columns_.count());
      add_row(surface_.data(), surface_.size(), heights_.row(l));
    }
  }

  // Finds the groups of columns and rows with a sample that overshoots, and moves them towards their bounds.
  void bound() {
    const std::int64_t down = y_.smoothed.count();
    lowest_ = lowest_rows_.shape(down, columns_.count());
    highest_ = highest_rows_.shape(down, columns_.count());
    cells_.clear();
    for (std::int64_t k = columns_.first; k <= columns_.last; ++k) {
      const IndexRange cell = x_.cell(k);
      cells_.push_back({static_cast<std::int32_t>(cell.first - smoothed_.columns.first),
                        static_cast<std::int32_t>(cell.last - smoothed_.columns.first)});
    }
    for (std::int64_t j = 0; j < down; ++j)
      widen(cells_, smoothed_.lowest.row(j), smoothed_.highest.row(j), lowest_.row(j), highest_.row(j));
    for (const auto& rows : y_.groups) bound_rows(rows);
  }

  BoundRows bounds_of(std::int64_t sample, std::int64_t column) const {
    const IndexRange cell = y_.cell(sample);
    const std::int64_t a = cell.first - y_.smoothed.first;
    const std::int64_t b = cell.last - y_.smoothed.first;
    return {{lowest_.row(a) + column, lowest_.row(b) + column},
            {highest_.row(a) + column, highest_.row(b) + column}};
  }

  bool any_overshoots_in(IndexRange rows, std::int64_t column, std::int64_t count) const {
    bool any = false;
    for (std::int64_t l = rows.first; l <= rows.last && !any; ++l) {
      any = any_overshoots(heights_.row(l - y_.samples.first) + column, bounds_of(l, column),
                           static_cast<std::size_t>(count), tolerance_.overshoot_m);
    }
    return any;
  }

  void bound_rows(const SmoothAxis::Group& rows) {
    if (!any_overshoots_in(rows.samples, 0, columns_.count())) return;
    for (const auto& columns : groups_) {
      const std::int64_t column = columns.samples.first - columns_.first;
      if (!any_overshoots_in(rows.samples, column, columns.samples.count())) continue;
      double* corner = heights_.row(rows.samples.first - y_.samples.first) + column;
      keep_bounds({x_, y_, columns, rows}, tolerance_, smoothed_, posts_, {corner, heights_.stride});
    }
  }

  void write() {
    const std::int64_t first = std::max(columns_.first, window_.x.first);
    const std::int64_t last = std::min(columns_.last, window_.x.last);
    for (std::int64_t l = window_.y.first; l <= window_.y.last; ++l) {
      round_row(heights_.row(l - y_.samples.first) + (first - columns_.first),
                static_cast<std::size_t>(last - first + 1), out_.data() + window_.offset(first, l));
    }
  }

  static void sum(const AxisWeights& weights, const AxisWeights::Row& row, Rows<const double> in,
                  std::int64_t first_post, double* out, std::int64_t count) {
    weighted_row_sum(weights.weights_of(row), {in.row(row.first - first_post), in.stride},
                     static_cast<std::size_t>(count), out);
  }

  const SmoothAxis& x_;
  const SmoothAxis& y_;
  SmoothTolerance tolerance_;
  std::span<const float> posts_;
  IndexWindow window_;
  std::span<float> out_;
  PostSmoothing smoothing_;

  // Of the strip: groups, sample columns, posts; and what is between the passes.
  std::span<const SmoothAxis::Group> groups_;
  IndexRange columns_;
  IndexRange corrected_;
  SmoothedPosts smoothed_;
  Scratch<double> turned_, along_, guess_rows_, at_posts_rows_, beyond_, corrections_rows_, heights_rows_;
  Scratch<float> lowest_rows_, highest_rows_;
  Rows<double> guess_, at_posts_, corrections_, heights_;
  std::vector<std::uint8_t> row_is_off_;
  std::vector<double> surface_;
  std::vector<CellColumns> cells_;  // by sample column
  Rows<float> lowest_, highest_;    // of the cells of each sample column, by row of smoothed posts
};

}  // namespace

void smooth_lattice(const SmoothAxis& x, const SmoothAxis& y, const SmoothTolerance& tolerance,
                    std::span<const float> posts, IndexWindow sample_window, std::span<float> out) {
  assert(posts.size() == static_cast<std::size_t>(x.posts.count() * y.posts.count()));
  assert(out.size() == static_cast<std::size_t>(sample_window.count()));
  assert(x.samples.holds(sample_window.x) && y.samples.holds(sample_window.y));
  if (is_constant(posts)) {
    std::fill(out.begin(), out.end(), posts.front());
    return;
  }
  SmoothWindow(x, y, tolerance, posts, sample_window, out).run();
}

}  // namespace cairn
