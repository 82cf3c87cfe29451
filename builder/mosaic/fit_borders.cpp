#include "builder/mosaic/fit_borders.h"

#include <algorithm>
#include <cmath>

#include "builder/resample/post_fit.h"

namespace cairn {
namespace {

constexpr std::int64_t kBlock = kFitBlock;
constexpr std::int64_t kHalo = kFitReach;
constexpr double kRounding = 5e-4;  // metres: of samples in single precision

std::int64_t rounded_down(std::int64_t at) {
  return at >= 0 ? at / kBlock * kBlock : -((-at + kBlock - 1) / kBlock) * kBlock;
}

struct Post {
  double x = 0;  // samples from the window's corner
  double y = 0;
  float height = 0;
  float interval_m = 0;
};

std::vector<Post> posts_of(const OverlaidSamples& samples, std::span<const double> intervals) {
  std::vector<Post> all;
  for (std::size_t k = 0; k < samples.posts.size(); ++k) {
    const MeasuredPosts& posts = samples.posts[k];
    const auto interval = static_cast<float>(intervals[k]);
    for (std::size_t r = 0; r < posts.ys.size(); ++r)
      for (std::size_t c = 0; c < posts.xs.size(); ++c) {
        const float height = posts.heights[r * posts.xs.size() + c];
        if (!std::isnan(height)) all.push_back({posts.xs[c], posts.ys[r], height, interval});
      }
    for (const MeasuredPosts::Placed& p : posts.placed) all.push_back({p.x, p.y, p.height, interval});
  }
  return all;
}

// A block with its halo, cut out of the window.
struct Block {
  int column = 0;  // of the halo's south-western sample in the window
  int row = 0;
  int side = 0;  // halo included
};

// Marks the samples of the block within kFitReach of a line between groups; empty where none runs through it.
// A group that ends where no other begins has no such line there.
std::vector<std::uint8_t> near_line(const Block& block, const SampleWindow& window,
                                    const std::vector<std::uint8_t>& touched,
                                    const std::vector<SampleState>& states) {
  const int side = block.side;
  std::vector<std::uint8_t> line(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  bool any = false;
  for (int r = 0; r < side; ++r) {
    const std::size_t row =
        static_cast<std::size_t>(block.row + r) * static_cast<std::size_t>(window.columns) +
        static_cast<std::size_t>(block.column);
    const auto between = [&](std::size_t a, std::size_t b) {
      return touched[a] != touched[b] && states[a] != SampleState::none && states[b] != SampleState::none;
    };
    for (int c = 0; c < side; ++c) {
      const std::size_t at = row + static_cast<std::size_t>(c);
      const bool differs = (c + 1 < side && between(at, at + 1)) ||
                           (r + 1 < side && between(at, at + static_cast<std::size_t>(window.columns)));
      line[static_cast<std::size_t>(r * side + c)] = differs ? 1 : 0;
      any = any || differs;
    }
  }
  if (!any) return {};
  // The greatest within reach, along rows and then along columns.
  const auto spread = [side](const std::vector<std::uint8_t>& from, int step, int across) {
    std::vector<std::uint8_t> to(from.size());
    for (int line_number = 0; line_number < side; ++line_number) {
      int last = -2 * side;
      for (int i = 0; i < side + kFitReach; ++i) {
        if (i < side && from[static_cast<std::size_t>(line_number * across + i * step)] != 0) last = i;
        const int at = i - kFitReach;
        if (at >= 0 && last >= at - kFitReach)
          to[static_cast<std::size_t>(line_number * across + at * step)] = 1;
      }
    }
    return to;
  };
  return spread(spread(line, 1, side), side, 1);
}

// The samples of the block, fitted; empty where nothing is to be done.
std::vector<float> fitted(const Block& block, const SampleWindow& window, const std::vector<Post>& posts,
                          const std::vector<float>& heights, double tolerance_m) {
  const auto side = static_cast<std::size_t>(block.side);
  std::vector<float> samples(side * side);
  for (int r = 0; r < block.side; ++r)
    std::copy_n(heights.begin() + static_cast<std::ptrdiff_t>(block.row + r) * window.columns + block.column,
                block.side, samples.begin() + static_cast<std::ptrdiff_t>(r) * block.side);
  PostEquations equations(block.side);
  bool off = false;
  for (const Post& p : posts) {
    const double x = p.x - block.column, y = p.y - block.row;
    if (x < 0 || y < 0 || x > block.side - 1 || y > block.side - 1) continue;
    const double c = std::min(std::floor(x), block.side - 2.0), r = std::min(std::floor(y), block.side - 2.0);
    const double s = x - c, t = y - r;
    const auto corner = static_cast<std::size_t>(r) * side + static_cast<std::size_t>(c);
    const double south =
        (1 - s) * static_cast<double>(samples[corner]) + s * static_cast<double>(samples[corner + 1]);
    const double north = (1 - s) * static_cast<double>(samples[corner + side]) +
                         s * static_cast<double>(samples[corner + side + 1]);
    const double surface = (1 - t) * south + t * north;
    if (std::isnan(surface)) continue;  // beside the end of all groups
    const double missed = surface - static_cast<double>(p.height);
    const auto interval = static_cast<double>(p.interval_m);
    const double inside = std::max(0.0, interval - 2 * tolerance_m);
    const bool within = std::abs(missed) <= interval + kRounding;
    off = off || !within;
    const double kept = within ? missed : std::clamp(missed, -inside, inside);
    equations.add(static_cast<std::int64_t>(corner), s, t,
                  static_cast<float>(static_cast<double>(p.height) + kept));
  }
  if (!off) return {};
  std::vector<bool> absent(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    absent[i] = std::isnan(samples[i]);
    if (absent[i]) samples[i] = 0;
  }
  (void)equations.fit(samples, {0, tolerance_m});
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (absent[i]) samples[i] = std::nanf("");
  return samples;
}

}  // namespace

SampleWindow fit_window(const SampleWindow& window) {
  SampleWindow wide = window;
  wide.column = rounded_down(window.column) - kHalo;
  wide.row = rounded_down(window.row) - kHalo;
  const std::int64_t east = rounded_down(window.column + window.columns - 1) + kBlock + kHalo;
  const std::int64_t north = rounded_down(window.row + window.rows - 1) + kBlock + kHalo;
  wide.columns = static_cast<int>(east - wide.column);
  wide.rows = static_cast<int>(north - wide.row);
  return wide;
}

void fit_borders(const SampleWindow& window, OverlaidSamples& samples, double tolerance_m,
                 std::span<const double> intervals) {
  constexpr int kSide = static_cast<int>(kBlock), kAround = static_cast<int>(kHalo);
  std::vector<Post> posts;
  const std::vector<float> before = samples.heights;
  const std::vector<std::uint8_t> touched = samples.touched;
  for (int row = 0; row + kSide + 2 * kAround <= window.rows; row += kSide) {
    for (int column = 0; column + kSide + 2 * kAround <= window.columns; column += kSide) {
      const Block block{column, row, kSide + 2 * kAround};
      const std::vector<std::uint8_t> near = near_line(block, window, touched, samples.states);
      if (near.empty()) continue;
      if (posts.empty()) posts = posts_of(samples, intervals);
      const std::vector<float> fit = fitted(block, window, posts, before, tolerance_m);
      if (fit.empty()) continue;
      for (int r = kAround; r < kAround + kSide; ++r) {
        for (int c = kAround; c < kAround + kSide; ++c) {
          const auto from = static_cast<std::size_t>(r * block.side + c);
          const auto to = static_cast<std::size_t>(row + r) * static_cast<std::size_t>(window.columns) +
                          static_cast<std::size_t>(column + c);
          if (near[from] == 0 || fit[from] == before[to] || std::isnan(fit[from])) continue;
          samples.heights[to] = fit[from];
          samples.touched[to] = std::max<std::uint8_t>(samples.touched[to], 1);
        }
      }
    }
  }
}

}  // namespace cairn
