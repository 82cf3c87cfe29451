#include "builder/voids/void_fill.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "builder/voids/fill_level.h"

namespace cairn {
namespace {

constexpr int kLevels = FillPyramid::kLevel;

// Per level the cells whose start matters to the window's result.
std::array<IndexWindow, kLevels> cells_needed(IndexWindow window) {
  std::array<IndexWindow, kLevels> needed;
  needed[0] = grown(window, kRelaxMargin);
  for (std::size_t level = 1; level < kLevels; ++level) {
    needed[level] = grown(pushed_from(needed[level - 1]), kRelaxMargin);
  }
  return needed;
}

FillLevel finest(std::span<const float> posts, IndexWindow window) {
  FillLevel level(window);
  for (std::size_t i = 0; i < posts.size(); ++i) {
    if (std::isnan(posts[i])) continue;
    level.heights[i] = posts[i];
    level.valid[i] = 1;
  }
  return level;
}

FillLevel part_of(const FillLevel& from, IndexWindow window) {
  FillLevel part(window);
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    const std::size_t at = from.window.offset(window.x.first, y);
    const std::size_t to = window.offset(window.x.first, y);
    std::copy_n(from.heights.begin() + static_cast<std::ptrdiff_t>(at), window.x.count(),
                part.heights.begin() + static_cast<std::ptrdiff_t>(to));
    std::copy_n(from.valid.begin() + static_cast<std::ptrdiff_t>(at), window.x.count(),
                part.valid.begin() + static_cast<std::ptrdiff_t>(to));
  }
  return part;
}

FillLevel pyramid_part(const FillPyramid& pyramid, IndexWindow cells) {
  FillLevel level(cells);
  for (std::int64_t y = cells.y.first; y <= cells.y.last; ++y) {
    for (std::int64_t x = cells.x.first; x <= cells.x.last; ++x) {
      level.heights[cells.offset(x, y)] = pyramid.at(x, y);
    }
  }
  return level;
}

void fill(const FillPyramid& pyramid, std::span<const float> posts, IndexWindow window,
          std::span<float> out) {
  const auto needed = cells_needed(window);
  std::vector<FillLevel> levels{finest(posts, posts_to_fill(window))};
  for (int level = 1; level < kLevels; ++level) {
    levels.push_back(pulled(levels.back(), covering(levels.back().window)));
  }
  FillLevel filled = pyramid_part(pyramid, pushed_from(needed[kLevels - 1]));
  for (std::size_t level = kLevels; level-- > 0;) {
    FillLevel part = part_of(levels[level], needed[level]);
    push(filled, part);
    relax(part);
    filled = std::move(part);
  }
  const FillLevel result = part_of(filled, window);
  std::copy(result.heights.begin(), result.heights.end(), out.begin());
}

}  // namespace

IndexWindow posts_to_fill(IndexWindow window) {
  IndexWindow cells = cells_needed(window)[kLevels - 1];
  for (int level = kLevels - 1; level > 0; --level) cells = covered_by(cells);
  return cells;
}

void fill_voids(const FillPyramid& pyramid, std::span<const float> posts, IndexWindow window,
                std::span<float> out) {
  const IndexWindow given = posts_to_fill(window);
  assert(posts.size() == static_cast<std::size_t>(given.count()));
  assert(out.size() == static_cast<std::size_t>(window.count()));
  bool any_void = false;
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    const std::span<const float> row =
        posts.subspan(given.offset(window.x.first, y), static_cast<std::size_t>(window.x.count()));
    std::copy(row.begin(), row.end(),
              out.begin() + static_cast<std::ptrdiff_t>(window.offset(window.x.first, y)));
    any_void = any_void || std::any_of(row.begin(), row.end(), [](float h) { return std::isnan(h); });
  }
  if (any_void && !pyramid.empty()) fill(pyramid, posts, window, out);
}

}  // namespace cairn
