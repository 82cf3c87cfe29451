#include "builder/resample/exact_run.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "builder/resample/cubic_kernel.h"

namespace cairn {
namespace {

// Rows of weights of the same consecutive posts.
class WeightRows {
 public:
  WeightRows(IndexRange posts, std::int64_t rows)
      : posts_(posts), weights_(static_cast<std::size_t>(posts.count() * rows)) {}

  std::span<double> row(std::size_t k) {
    const auto width = static_cast<std::size_t>(posts_.count());
    return std::span(weights_).subspan(k * width, width);
  }
  double& at(std::size_t k, std::int64_t post) {
    return row(k)[static_cast<std::size_t>(post - posts_.first)];
  }

 private:
  IndexRange posts_;
  std::vector<double> weights_;
};

void add_multiple(std::span<double> to, double factor, std::span<const double> of) {
  for (std::size_t c = 0; c < to.size(); ++c) to[c] += factor * of[c];
}

// Row i of A: the weights of the two samples around post i.
using PostRow = std::array<double, 2>;

struct RunRows {
  IndexRange touched;  // samples, those on posts included
  std::vector<PostRow> all;
  std::vector<PostRow> corrected;  // 0 for samples on posts, which stay as they are
};

RunRows rows_of(const AxisPositions& axis, const PostRun& run) {
  RunRows rows;
  rows.touched = {axis.interval_of(run.posts.first), axis.interval_of(run.posts.last) + 1};
  for (std::int64_t post = run.posts.first; post <= run.posts.last; ++post) {
    const double t = axis.fraction_of(post);
    rows.all.push_back({1 - t, t});
  }
  rows.corrected = rows.all;
  if (run.samples.first != rows.touched.first) rows.corrected.front()[0] = 0;
  if (run.samples.last != rows.touched.last) rows.corrected.back()[1] = 0;
  return rows;
}

WeightRows first_guess(const AxisPositions& axis, IndexRange samples, IndexRange posts) {
  WeightRows guess(posts, samples.count());
  for (std::int64_t k = samples.first; k <= samples.last; ++k) {
    const PostTaps taps = taps_at(axis, k, ResampleMethod::cubic);
    std::copy_n(taps.values.begin(), taps.count,
                &guess.at(static_cast<std::size_t>(k - samples.first), taps.first));
  }
  return guess;
}

// H - A·G0
WeightRows residuals(WeightRows& guess, std::span<const PostRow> a, const PostRun& run, IndexRange posts) {
  WeightRows r(posts, run.posts.count());
  for (std::size_t i = 0; i < a.size(); ++i) {
    r.at(i, run.posts.first + static_cast<std::int64_t>(i)) = 1;
    add_multiple(r.row(i), -a[i][0], guess.row(i));
    add_multiple(r.row(i), -a[i][1], guess.row(i + 1));
  }
  return r;
}

// r := (AAᵀ)⁻¹·r by elimination, which needs no pivoting where a matrix is positive definite.
void solve(WeightRows& r, std::span<const PostRow> a) {
  std::vector<double> pivot(a.size());
  std::vector<double> beside(a.size());  // the element left of the diagonal
  for (std::size_t i = 0; i < a.size(); ++i) {
    pivot[i] = a[i][0] * a[i][0] + a[i][1] * a[i][1];
    if (i == 0) continue;
    beside[i] = a[i - 1][1] * a[i][0];
    const double factor = beside[i] / pivot[i - 1];
    pivot[i] -= factor * beside[i];
    add_multiple(r.row(i), -factor, r.row(i - 1));
  }
  for (std::size_t i = a.size(); i-- > 0;) {
    for (double& weight : r.row(i)) weight /= pivot[i];
    if (i > 0) add_multiple(r.row(i - 1), -beside[i], r.row(i));
  }
}

bool coupled(const AxisPositions& axis, std::int64_t post, std::int64_t next) {
  return axis.fraction_of(post) != 0 && axis.fraction_of(next) != 0 &&
         axis.interval_of(next) == axis.interval_of(post) + 1;
}

}  // namespace

std::optional<PostRun> run_at(const AxisPositions& axis, std::int64_t sample) {
  std::int64_t post = axis.first_post_from(sample);
  const bool above = axis.interval_of(post) == sample;
  const bool below = axis.interval_of(post - 1) == sample - 1 && axis.fraction_of(post - 1) != 0;
  if (!above && !below) return std::nullopt;
  if (!above) --post;
  PostRun run{{post, post}, {}};
  while (coupled(axis, run.posts.first - 1, run.posts.first)) --run.posts.first;
  while (coupled(axis, run.posts.last, run.posts.last + 1)) ++run.posts.last;
  run.samples = {axis.interval_of(run.posts.first), axis.interval_of(run.posts.last) + 1};
  if (axis.is_on_post(run.samples.first)) ++run.samples.first;
  if (axis.is_on_post(run.samples.last)) --run.samples.last;
  return run;
}

IndexRange posts_under(const AxisPositions& axis, const PostRun& run) {
  IndexRange posts = run.posts;
  // The touched samples on posts are a post beyond the run at most, which the cubic of their neighbour uses.
  for (std::int64_t k = run.samples.first; k <= run.samples.last; ++k) {
    const PostTaps taps = taps_at(axis, k, ResampleMethod::cubic);
    posts.first = std::min(posts.first, taps.first);
    posts.last = std::max(posts.last, taps.last());
  }
  return posts;
}

void append_exact_rows(const AxisPositions& axis, const PostRun& run, IndexRange samples, AxisWeights& to) {
  assert(run.samples.first <= samples.first && samples.last <= run.samples.last);
  const IndexRange posts = posts_under(axis, run);
  const RunRows rows = rows_of(axis, run);
  WeightRows g = first_guess(axis, rows.touched, posts);
  WeightRows lambda = residuals(g, rows.all, run, posts);
  solve(lambda, rows.corrected);
  for (std::size_t i = 0; i < rows.corrected.size(); ++i) {
    add_multiple(g.row(i), rows.corrected[i][0], lambda.row(i));
    add_multiple(g.row(i + 1), rows.corrected[i][1], lambda.row(i));
  }
  for (std::int64_t k = samples.first; k <= samples.last; ++k) {
    to.append(posts.first, g.row(static_cast<std::size_t>(k - rows.touched.first)));
  }
}

void append_correction_rows(const AxisPositions& axis, const PostRun& run, AxisWeights& to) {
  const RunRows rows = rows_of(axis, run);
  assert(rows.touched == run.samples);
  WeightRows lambda(run.posts, run.posts.count());
  for (std::size_t i = 0; i < rows.all.size(); ++i) {
    lambda.at(i, run.posts.first + static_cast<std::int64_t>(i)) = 1;
  }
  solve(lambda, rows.all);
  WeightRows correction(run.posts, rows.touched.count());
  for (std::size_t i = 0; i < rows.all.size(); ++i) {
    add_multiple(correction.row(i), rows.all[i][0], lambda.row(i));
    add_multiple(correction.row(i + 1), rows.all[i][1], lambda.row(i));
  }
  for (std::int64_t k = 0; k < rows.touched.count(); ++k) {
    to.append(run.posts.first, correction.row(static_cast<std::size_t>(k)));
  }
}

}  // namespace cairn
