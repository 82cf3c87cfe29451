#pragma once

#include <cstdint>

namespace cairn {

/// A closed range of post or sample indices: first … last.
struct IndexRange {
  std::int64_t first = 0;
  std::int64_t last = -1;

  std::int64_t count() const { return last - first + 1; }
  bool holds(std::int64_t index) const { return first <= index && index <= last; }
  bool holds(IndexRange other) const { return first <= other.first && other.last <= last; }
  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

/// a / b, rounded down. REQUIRES: b > 0.
inline std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

/// A rectangle of posts by their lattice indices, or of samples by theirs; x eastwards, y northwards. Heights
/// of a window are row-major, rows south to north.
struct IndexWindow {
  IndexRange x;
  IndexRange y;

  std::int64_t count() const { return x.count() * y.count(); }
  bool holds(IndexWindow other) const { return x.holds(other.x) && y.holds(other.y); }
  std::size_t offset(std::int64_t column, std::int64_t row) const {
    return static_cast<std::size_t>((row - y.first) * x.count() + (column - x.first));
  }
  friend bool operator==(const IndexWindow&, const IndexWindow&) = default;
};

}  // namespace cairn
