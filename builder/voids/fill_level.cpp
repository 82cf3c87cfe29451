#include "builder/voids/fill_level.h"

#include <algorithm>

namespace cairn {
namespace {

constexpr int kSweeps = kRelaxMargin / 2;  // each has a red and a black half, which see one cell farther

IndexRange halves(IndexRange cells) {
  return {cells.first >> 1, cells.last >> 1};
}

// The nearer and the farther coarse cell of a fine one, 3/4 and 1/4 of the interpolant.
struct Parents {
  std::int64_t near = 0;
  std::int64_t far = 0;
};

Parents parents_of(std::int64_t cell, IndexRange coarse) {
  const std::int64_t near = cell >> 1;
  const std::int64_t far = (cell & 1) != 0 ? near + 1 : near - 1;
  return {std::clamp(near, coarse.first, coarse.last), std::clamp(far, coarse.first, coarse.last)};
}

void pull_cell(const FillLevel& from, FillLevel& to, std::int64_t x, std::int64_t y) {
  float sum = 0;
  float weight = 0;
  for (std::int64_t fy = std::max(2 * y, from.window.y.first); fy <= std::min(2 * y + 1, from.window.y.last);
       ++fy) {
    for (std::int64_t fx = std::max(2 * x, from.window.x.first);
         fx <= std::min(2 * x + 1, from.window.x.last); ++fx) {
      const std::size_t at = from.window.offset(fx, fy);
      sum += from.valid[at] * from.heights[at];
      weight += from.valid[at];
    }
  }
  if (weight == 0) return;
  to.heights[to.window.offset(x, y)] = sum / weight;
  to.valid[to.window.offset(x, y)] = weight / 4;
}

void relax_row(FillLevel& level, std::int64_t y, int colour) {
  const IndexWindow& w = level.window;
  const float* above = &level.heights[w.offset(w.x.first, std::min(y + 1, w.y.last))];
  const float* below = &level.heights[w.offset(w.x.first, std::max(y - 1, w.y.first))];
  float* row = &level.heights[w.offset(w.x.first, y)];
  const float* valid = &level.valid[w.offset(w.x.first, y)];
  const auto last = static_cast<std::ptrdiff_t>(w.x.count() - 1);
  for (std::ptrdiff_t i = (w.x.first + y + colour) & 1; i <= last; i += 2) {
    if (valid[i] > 0) continue;
    row[i] = 0.25f *
             ((row[std::max<std::ptrdiff_t>(i - 1, 0)] + row[std::min(i + 1, last)]) + (below[i] + above[i]));
  }
}

}  // namespace

FillLevel::FillLevel(IndexWindow cells)
    : window(cells), heights(static_cast<std::size_t>(cells.count())), valid(heights.size()) {}

IndexWindow grown(IndexWindow cells, std::int64_t by) {
  return {{cells.x.first - by, cells.x.last + by}, {cells.y.first - by, cells.y.last + by}};
}

IndexWindow covered_by(IndexWindow cells) {
  return {{2 * cells.x.first, 2 * cells.x.last + 1}, {2 * cells.y.first, 2 * cells.y.last + 1}};
}

IndexWindow covering(IndexWindow cells) {
  return {halves(cells.x), halves(cells.y)};
}

IndexWindow pushed_from(IndexWindow cells) {
  return covering(grown(cells, 1));
}

FillLevel pulled(const FillLevel& from, IndexWindow window) {
  FillLevel to(window);
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x) pull_cell(from, to, x, y);
  }
  return to;
}

void push(const FillLevel& coarse, FillLevel& to) {
  const auto from = [&coarse](std::int64_t x, std::int64_t y) {
    return coarse.heights[coarse.window.offset(x, y)];
  };
  for (std::int64_t y = to.window.y.first; y <= to.window.y.last; ++y) {
    const Parents py = parents_of(y, coarse.window.y);
    for (std::int64_t x = to.window.x.first; x <= to.window.x.last; ++x) {
      const std::size_t at = to.window.offset(x, y);
      if (to.valid[at] > 0) continue;
      const Parents px = parents_of(x, coarse.window.x);
      const float near = 0.75f * from(px.near, py.near) + 0.25f * from(px.far, py.near);
      const float far = 0.75f * from(px.near, py.far) + 0.25f * from(px.far, py.far);
      to.heights[at] = 0.75f * near + 0.25f * far;
    }
  }
}

void relax(FillLevel& level) {
  for (int half = 0; half < 2 * kSweeps; ++half) {
    for (std::int64_t y = level.window.y.first; y <= level.window.y.last; ++y) relax_row(level, y, half & 1);
  }
}

}  // namespace cairn
