#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "builder/resample/index_window.h"

namespace cairn {

/// Which of many rectangles of a grid reach into a window, in a time that does not grow with their number:
/// they are looked up by cells about as large as one of them.
class WindowIndex {
 public:
  explicit WindowIndex(std::vector<IndexWindow> extents);

  const std::vector<IndexWindow>& extents() const { return extents_; }
  /// The smallest window around all; empty where there are none.
  IndexWindow hull() const { return hull_; }
  /// Their numbers, ascending.
  std::vector<std::size_t> overlapping(const IndexWindow& window) const;

  /// A rectangle that reaches into a window after it was moved by `turn` columns.
  struct Turned {
    std::size_t number = 0;
    std::int64_t turn = 0;
    friend auto operator<=>(const Turned&, const Turned&) = default;
  };
  /// The same for rectangles that repeat every `around` columns, moved by at most one turn each way: by their
  /// numbers, ascending, then by turn.
  std::vector<Turned> overlapping(const IndexWindow& window, std::int64_t around) const;

 private:
  IndexWindow cells_of(const IndexWindow& window) const;

  std::vector<IndexWindow> extents_;
  IndexWindow hull_;
  std::int64_t cell_ = 1;  // columns and rows along the side of a cell
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> by_cell_;
};

}  // namespace cairn
