#include "builder/mosaic/upsample.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

struct Neighbours {
  int low = 0;
  int high = 0;  // = low where the sample is one of the coarser level's own
  float fraction = 0;
};

// Where each fine sample of an axis lies among the coarse window's.
std::vector<Neighbours> neighbours(std::int64_t fine_first, int count, std::int64_t coarse_first,
                                   int levels) {
  const std::int64_t step = std::int64_t{1} << levels;
  std::vector<Neighbours> all;
  for (std::int64_t fine = fine_first; fine < fine_first + count; ++fine) {
    const std::int64_t rest = fine & (step - 1);
    const auto low = static_cast<int>((fine >> levels) - coarse_first);
    all.push_back(
        {low, rest == 0 ? low : low + 1, static_cast<float>(std::ldexp(static_cast<double>(rest), -levels))});
  }
  return all;
}

float between(float a, float b, float fraction) {
  return fraction == 0 ? a : a * (1 - fraction) + b * fraction;
}

// Which of the places, moved to the fine window's samples, lie in it.
std::vector<std::size_t> move_into(std::vector<double>& places, std::int64_t from_first,
                                   std::int64_t to_first, int count, int levels) {
  std::vector<std::size_t> kept;
  std::vector<double> moved;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double at =
        std::ldexp(places[i] + static_cast<double>(from_first), levels) - static_cast<double>(to_first);
    if (at < 0 || at > count - 1) continue;
    kept.push_back(i);
    moved.push_back(at);
  }
  places = std::move(moved);
  return kept;
}

std::vector<MeasuredPosts::Placed> placed_in(const std::vector<MeasuredPosts::Placed>& placed,
                                             const SampleWindow& from, const SampleWindow& to, int levels) {
  std::vector<MeasuredPosts::Placed> out;
  for (MeasuredPosts::Placed p : placed) {
    p.x = std::ldexp(p.x + static_cast<double>(from.column), levels) - static_cast<double>(to.column);
    p.y = std::ldexp(p.y + static_cast<double>(from.row), levels) - static_cast<double>(to.row);
    if (p.x >= 0 && p.y >= 0 && p.x <= to.columns - 1 && p.y <= to.rows - 1) out.push_back(p);
  }
  return out;
}

// Interpolates values between the coarse samples.
std::vector<float> interpolated(const std::vector<float>& values, const std::vector<Neighbours>& columns,
                                const std::vector<Neighbours>& rows, int coarse_columns) {
  std::vector<float> out;
  out.reserve(columns.size() * rows.size());
  for (const Neighbours& r : rows) {
    const float* low = values.data() + r.low * coarse_columns;
    const float* high = values.data() + r.high * coarse_columns;
    for (const Neighbours& c : columns) {
      out.push_back(between(between(low[c.low], low[c.high], c.fraction),
                            between(high[c.low], high[c.high], c.fraction), r.fraction));
    }
  }
  return out;
}

// Combines what the samples around each place are.
template <class T, class Combine>
std::vector<T> combined(const std::vector<T>& values, const std::vector<Neighbours>& columns,
                        const std::vector<Neighbours>& rows, int coarse_columns, const Combine& combine) {
  const auto at = [&](int c, int r) { return values[static_cast<std::size_t>(r * coarse_columns + c)]; };
  std::vector<T> out;
  out.reserve(columns.size() * rows.size());
  for (const Neighbours& r : rows)
    for (const Neighbours& c : columns)
      out.push_back(combine({at(c.low, r.low), at(c.high, r.low), at(c.low, r.high), at(c.high, r.high)}));
  return out;
}

}  // namespace

MeasuredPosts posts_in(const MeasuredPosts& posts, const SampleWindow& from, const SampleWindow& to,
                       int levels) {
  MeasuredPosts out;
  out.xs = posts.xs;
  out.ys = posts.ys;
  const auto columns = move_into(out.xs, from.column, to.column, to.columns, levels);
  const auto rows = move_into(out.ys, from.row, to.row, to.rows, levels);
  for (const std::size_t r : rows) {
    for (const std::size_t c : columns) {
      out.heights.push_back(posts.heights[r * posts.xs.size() + c]);
      out.owners.push_back(posts.owners[r * posts.xs.size() + c]);
    }
  }
  out.placed = placed_in(posts.placed, from, to, levels);
  out.lost = placed_in(posts.lost, from, to, levels);
  return out;
}

SampleWindow coarser_window(const SampleWindow& window, int levels) {
  const auto last = [levels](std::int64_t fine) { return -((-fine) >> levels); };  // rounded up
  SampleWindow coarse{window.column >> levels, window.row >> levels, 0, 0,
                      std::ldexp(window.samples_per_degree, -levels)};
  coarse.columns = static_cast<int>(last(window.column + window.columns - 1) - coarse.column + 1);
  coarse.rows = static_cast<int>(last(window.row + window.rows - 1) - coarse.row + 1);
  return coarse;
}

GroupSamples upsample(const GroupSamples& coarse, const SampleWindow& window, int levels) {
  const SampleWindow from = coarser_window(window, levels);
  const auto columns = neighbours(window.column, window.columns, from.column, levels);
  const auto rows = neighbours(window.row, window.rows, from.row, levels);
  const auto worst = [](std::initializer_list<SampleState> around) { return std::min(around); };
  GroupSamples fine;
  fine.heights = interpolated(coarse.heights, columns, rows, from.columns);
  if (!coarse.fill_weights.empty())
    fine.fill_weights = interpolated(coarse.fill_weights, columns, rows, from.columns);
  if (!coarse.states.empty()) fine.states = combined(coarse.states, columns, rows, from.columns, worst);
  fine.posts = posts_in(coarse.posts, from, window, levels);
  return fine;
}

OverlaidSamples upsample(const OverlaidSamples& coarse, const SampleWindow& from, const SampleWindow& window,
                         int levels) {
  const auto columns = neighbours(window.column, window.columns, from.column, levels);
  const auto rows = neighbours(window.row, window.rows, from.row, levels);
  OverlaidSamples fine;
  fine.heights = interpolated(coarse.heights, columns, rows, from.columns);
  fine.states = combined(coarse.states, columns, rows, from.columns,
                         [](std::initializer_list<SampleState> around) { return std::min(around); });
  fine.touched = combined(coarse.touched, columns, rows, from.columns,
                          [](std::initializer_list<std::uint8_t> around) { return std::max(around); });
  for (const MeasuredPosts& posts : coarse.posts) fine.posts.push_back(posts_in(posts, from, window, levels));
  return fine;
}

OverlaidSamples cut(const OverlaidSamples& samples, const SampleWindow& from, const SampleWindow& window) {
  return upsample(samples, from, window, 0);
}

}  // namespace cairn
