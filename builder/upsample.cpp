#include "builder/upsample.h"

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

MeasuredPosts moved(const MeasuredPosts& posts, const SampleWindow& from, const SampleWindow& to,
                    int levels) {
  MeasuredPosts out = posts;
  const double scale = std::ldexp(1.0, levels);
  const auto place = [&](double at, std::int64_t from_first, std::int64_t to_first) {
    return (at + static_cast<double>(from_first)) * scale - static_cast<double>(to_first);
  };
  for (double& x : out.xs) x = place(x, from.column, to.column);
  for (double& y : out.ys) y = place(y, from.row, to.row);
  for (auto& p : out.placed) {
    p.x = place(p.x, from.column, to.column);
    p.y = place(p.y, from.row, to.row);
  }
  return out;
}

}  // namespace

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
  GroupSamples fine;
  fine.heights.reserve(window.count());
  for (const Neighbours& r : rows) {
    const float* low = coarse.heights.data() + r.low * from.columns;
    const float* high = coarse.heights.data() + r.high * from.columns;
    for (const Neighbours& c : columns) {
      fine.heights.push_back(between(between(low[c.low], low[c.high], c.fraction),
                                     between(high[c.low], high[c.high], c.fraction), r.fraction));
    }
  }
  if (!coarse.states.empty()) {
    const auto state = [&](int c, int r) {
      return coarse.states[static_cast<std::size_t>(r * from.columns + c)];
    };
    for (const Neighbours& r : rows) {
      for (const Neighbours& c : columns) {
        fine.states.push_back(std::min(
            {state(c.low, r.low), state(c.high, r.low), state(c.low, r.high), state(c.high, r.high)}));
      }
    }
  }
  fine.posts = moved(coarse.posts, from, window, levels);
  return fine;
}

}  // namespace cairn
