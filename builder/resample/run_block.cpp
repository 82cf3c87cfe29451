#include "builder/resample/run_block.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace cairn {
namespace {

constexpr int kRounds = 6;
constexpr double kRelaxation = 1.5;

struct Bounds {
  double lowest;
  double highest;
};

class BlockProjections {
 public:
  BlockProjections(const RunBlock& block, const SmoothTolerance& tolerance, const SmoothedPosts& smoothed,
                   std::span<const float> posts, Rows<double> heights)
      : b_(block), tolerance_(tolerance), posts_(posts), heights_(heights) {
    for (std::int64_t l = b_.rows.samples.first; l <= b_.rows.samples.last; ++l) {
      for (std::int64_t k = b_.columns.samples.first; k <= b_.columns.samples.last; ++k)
        bounds_.push_back(bounds_at(smoothed, b_.x.cell(k), b_.y.cell(l)));
    }
    missing_.resize(static_cast<std::size_t>(b_.columns.posts.count() * b_.rows.posts.count()));
    along_.resize(static_cast<std::size_t>(b_.columns.samples.count() * b_.rows.posts.count()));
  }

  void run() {
    for (int round = 0; round < kRounds && any_overshoots(); ++round) {
      project_onto_bounds();
      if (find_missing()) correct();
    }
  }

 private:
  Bounds bounds_at(const SmoothedPosts& smoothed, IndexRange columns, IndexRange rows) const {
    float lowest = std::numeric_limits<float>::infinity();
    float highest = -lowest;
    for (std::int64_t j = rows.first; j <= rows.last; ++j) {
      for (std::int64_t i = columns.first; i <= columns.last; ++i) {
        lowest = std::min(lowest, smoothed.lowest.row(j - b_.y.smoothed.first)[i - smoothed.columns.first]);
        highest =
            std::max(highest, smoothed.highest.row(j - b_.y.smoothed.first)[i - smoothed.columns.first]);
      }
    }
    return {static_cast<double>(lowest), static_cast<double>(highest)};
  }

  bool any_overshoots() const {
    const Bounds* bounds = bounds_.data();
    for (std::ptrdiff_t r = 0; r < b_.rows.samples.count(); ++r) {
      for (std::ptrdiff_t c = 0; c < b_.columns.samples.count(); ++c, ++bounds) {
        const double h = heights_.row(r)[c];
        if (bounds->lowest - h > tolerance_.overshoot_m || h - bounds->highest > tolerance_.overshoot_m)
          return true;
      }
    }
    return false;
  }

  void project_onto_bounds() {
    const Bounds* bounds = bounds_.data();
    for (std::ptrdiff_t r = 0; r < b_.rows.samples.count(); ++r) {
      for (std::ptrdiff_t c = 0; c < b_.columns.samples.count(); ++c, ++bounds) {
        double& h = heights_.row(r)[c];
        h += kRelaxation * (std::clamp(h, bounds->lowest, bounds->highest) - h);
      }
    }
  }

  double surface_at(std::int64_t i, std::int64_t j) const {
    const auto px = static_cast<std::size_t>(i - b_.x.corrected.first);
    const auto py = static_cast<std::size_t>(j - b_.y.corrected.first);
    const std::ptrdiff_t c = b_.x.interval[px] - b_.columns.samples.first;
    const std::ptrdiff_t r = b_.y.interval[py] - b_.rows.samples.first;
    const double u = b_.x.fraction[px];
    const double v = b_.y.fraction[py];
    const auto along = [&](std::ptrdiff_t row) {
      const double* h = heights_.row(row) + c;
      return u == 0 ? h[0] : (1 - u) * h[0] + u * h[1];
    };
    return v == 0 ? along(r) : (1 - v) * along(r) + v * along(r + 1);
  }

  // What the surface lacks, at each post, of coming within the interval. Returns whether it lacks anything.
  bool find_missing() {
    bool any = false;
    double* to = missing_.data();
    for (std::int64_t j = b_.rows.posts.first; j <= b_.rows.posts.last; ++j) {
      const float* row = posts_.data() + (j - b_.y.posts.first) * b_.x.posts.count() - b_.x.posts.first;
      for (std::int64_t i = b_.columns.posts.first; i <= b_.columns.posts.last; ++i) {
        const double r = static_cast<double>(row[i]) - surface_at(i, j);
        *to = r - std::clamp(r, -tolerance_.interval_m, tolerance_.interval_m);
        any = any || *to != 0;
        ++to;
      }
    }
    return any;
  }

  void correct() {
    const std::ptrdiff_t columns = b_.columns.samples.count();
    const std::ptrdiff_t from = b_.columns.posts.count();
    const std::ptrdiff_t rows = b_.rows.posts.count();
    for (std::ptrdiff_t c = 0; c < columns; ++c) {
      const auto w = b_.x.correction.weights_of(b_.x.correction_row(b_.columns.samples.first + c));
      for (std::ptrdiff_t j = 0; j < rows; ++j) {
        double sum = 0;
        for (std::ptrdiff_t i = 0; i < from; ++i)
          sum += w[static_cast<std::size_t>(i)] * missing_[static_cast<std::size_t>(j * from + i)];
        along_[static_cast<std::size_t>(j * columns + c)] = sum;
      }
    }
    for (std::ptrdiff_t r = 0; r < b_.rows.samples.count(); ++r) {
      const auto w = b_.y.correction.weights_of(b_.y.correction_row(b_.rows.samples.first + r));
      for (std::ptrdiff_t j = 0; j < rows; ++j) {
        for (std::ptrdiff_t c = 0; c < columns; ++c) {
          heights_.row(r)[c] +=
              w[static_cast<std::size_t>(j)] * along_[static_cast<std::size_t>(j * columns + c)];
        }
      }
    }
  }

  const RunBlock& b_;
  SmoothTolerance tolerance_;
  std::span<const float> posts_;
  Rows<double> heights_;
  std::vector<Bounds> bounds_;   // by sample
  std::vector<double> missing_;  // by post
  std::vector<double> along_;    // the corrections of the posts' rows, by sample column
};

}  // namespace

void keep_bounds(const RunBlock& block, const SmoothTolerance& tolerance, const SmoothedPosts& smoothed,
                 std::span<const float> posts, Rows<double> heights) {
  BlockProjections(block, tolerance, smoothed, posts, heights).run();
}

}  // namespace cairn
