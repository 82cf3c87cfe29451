#include "builder/voids/fill_pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "builder/voids/fill_level.h"

namespace cairn {
namespace {

constexpr double kSumsPerMetre = 65536;
constexpr float kMostMetres = 1 << 20;

IndexRange cells_of(IndexRange posts) {
  return {posts.first >> FillPyramid::kLevel, posts.last >> FillPyramid::kLevel};
}

std::int64_t to_sum(float height) {
  return std::llrint(static_cast<double>(std::clamp(height, -kMostMetres, kMostMetres)) * kSumsPerMetre);
}

void fill_with_mean(FillLevel& level) {
  float sum = 0;
  float weight = 0;
  for (std::size_t c = 0; c < level.heights.size(); ++c) {
    sum += level.valid[c] * level.heights[c];
    weight += level.valid[c];
  }
  for (std::size_t c = 0; c < level.heights.size(); ++c) {
    if (level.valid[c] == 0) level.heights[c] = sum / weight;
  }
}

void fill(FillLevel& level) {
  const IndexWindow above = covering(level.window);
  // No coarser cell covers index -1 as well as 0.
  if (above == level.window) return fill_with_mean(level);
  FillLevel coarse = pulled(level, above);
  fill(coarse);
  push(coarse, level);
  relax(level);
}

}  // namespace

float FillPyramid::at(std::int64_t x, std::int64_t y) const {
  assert(!empty());
  return heights_[cells_.offset(std::clamp(x, cells_.x.first, cells_.x.last),
                                std::clamp(y, cells_.y.first, cells_.y.last))];
}

FillPyramidBuilder::FillPyramidBuilder(IndexWindow posts)
    : cells_{cells_of(posts.x), cells_of(posts.y)},
      sums_(static_cast<std::size_t>(cells_.count())),
      counts_(sums_.size()) {
  assert(posts.x.count() > 0 && posts.y.count() > 0);
}

void FillPyramidBuilder::add(IndexWindow window, std::span<const float> heights) {
  assert(heights.size() == static_cast<std::size_t>(window.count()));
  assert(cells_.holds({cells_of(window.x), cells_of(window.y)}));
  const float* height = heights.data();
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x, ++height) {
      if (std::isnan(*height)) continue;
      const std::size_t cell = cells_.offset(x >> FillPyramid::kLevel, y >> FillPyramid::kLevel);
      sums_[cell] += to_sum(*height);
      ++counts_[cell];
      ++valid_posts_;
    }
  }
}

FillPyramid FillPyramidBuilder::complete() const {
  FillPyramid pyramid;
  if (valid_posts_ == 0) return pyramid;
  FillLevel level(cells_);
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    if (counts_[c] == 0) continue;
    level.heights[c] = static_cast<float>(static_cast<double>(sums_[c]) / (kSumsPerMetre * counts_[c]));
    level.valid[c] = static_cast<float>(counts_[c]) / 1024;
  }
  fill(level);
  pyramid.cells_ = cells_;
  pyramid.heights_ = std::move(level.heights);
  return pyramid;
}

}  // namespace cairn
