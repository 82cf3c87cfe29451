#include "builder/resample/window_index.h"

#include <algorithm>
#include <utility>

namespace cairn {
namespace {

bool overlap(const IndexWindow& a, const IndexWindow& b) {
  return a.x.first <= b.x.last && b.x.first <= a.x.last && a.y.first <= b.y.last && b.y.first <= a.y.last;
}

// Cells are numbered in one number, as nobody has 2^31 of them along an axis.
std::int64_t number_of(std::int64_t x, std::int64_t y) {
  return y * (std::int64_t{1} << 32) + x;
}

}  // namespace

WindowIndex::WindowIndex(std::vector<IndexWindow> extents) : extents_(std::move(extents)) {
  if (extents_.empty()) return;
  hull_ = extents_.front();
  std::int64_t sides = 0;
  for (const IndexWindow& e : extents_) {
    hull_ = {{std::min(hull_.x.first, e.x.first), std::max(hull_.x.last, e.x.last)},
             {std::min(hull_.y.first, e.y.first), std::max(hull_.y.last, e.y.last)}};
    sides += std::max(e.x.count(), e.y.count());
  }
  // About as large as a member, so that each lies in a few cells.
  cell_ = std::max<std::int64_t>({sides / static_cast<std::int64_t>(extents_.size()),
                                  std::max(hull_.x.count(), hull_.y.count()) / 1024, 64});
  for (std::size_t m = 0; m < extents_.size(); ++m) {
    const IndexWindow cells = cells_of(extents_[m]);
    for (std::int64_t y = cells.y.first; y <= cells.y.last; ++y) {
      for (std::int64_t x = cells.x.first; x <= cells.x.last; ++x)
        by_cell_[number_of(x, y)].push_back(static_cast<std::uint32_t>(m));
    }
  }
}

IndexWindow WindowIndex::cells_of(const IndexWindow& w) const {
  return {{floor_divide(w.x.first, cell_), floor_divide(w.x.last, cell_)},
          {floor_divide(w.y.first, cell_), floor_divide(w.y.last, cell_)}};
}

std::vector<std::size_t> WindowIndex::overlapping(const IndexWindow& window) const {
  const IndexWindow within{{std::max(window.x.first, hull_.x.first), std::min(window.x.last, hull_.x.last)},
                           {std::max(window.y.first, hull_.y.first), std::min(window.y.last, hull_.y.last)}};
  std::vector<std::size_t> found;
  if (within.x.count() <= 0 || within.y.count() <= 0) return found;
  const IndexWindow cells = cells_of(within);
  for (std::int64_t y = cells.y.first; y <= cells.y.last; ++y) {
    for (std::int64_t x = cells.x.first; x <= cells.x.last; ++x) {
      const auto cell = by_cell_.find(number_of(x, y));
      if (cell == by_cell_.end()) continue;
      for (const std::uint32_t m : cell->second)
        if (overlap(extents_[m], within)) found.push_back(m);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<WindowIndex::Turned> WindowIndex::overlapping(const IndexWindow& window,
                                                          std::int64_t around) const {
  std::vector<Turned> found;
  for (const std::int64_t turn : {-around, std::int64_t{0}, around}) {
    const IndexWindow moved{{window.x.first - turn, window.x.last - turn}, window.y};
    for (const std::size_t number : overlapping(moved)) found.push_back({number, turn});
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace cairn
