#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "builder/resample/weighted_row_sum.h"

namespace cairn {

/// Columns that a resampling handles at a time, so that what lies between its passes stays in the cache.
constexpr std::ptrdiff_t kStripColumns = 64;

/// Writes row r of `in` to column r of `out`.
template <class T>
void transpose(Rows<const T> in, std::ptrdiff_t rows, std::ptrdiff_t columns, Rows<double> out) {
  constexpr std::ptrdiff_t tile = 8;
  for (std::ptrdiff_t r0 = 0; r0 < rows; r0 += tile) {
    const std::ptrdiff_t r1 = std::min(r0 + tile, rows);
    for (std::ptrdiff_t c = 0; c < columns; ++c) {
      for (std::ptrdiff_t r = r0; r < r1; ++r) out.row(c)[r] = static_cast<double>(in.row(r)[c]);
    }
  }
}

/// Numbers that are laid out anew for each strip, and allocated anew only where a strip needs more.
template <class T>
class Scratch {
 public:
  /// The numbers are left as they are.
  Rows<T> shape(std::ptrdiff_t rows, std::ptrdiff_t columns) {
    const std::ptrdiff_t count = rows * columns;
    if (count > capacity_) {
      capacity_ = count + count / 8;
      numbers_ = std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(capacity_));
    }
    return {numbers_.get(), columns};
  }

 private:
  std::unique_ptr<T[]> numbers_;
  std::ptrdiff_t capacity_ = 0;
};

template <class T>
Rows<const T> read(Rows<T> rows, std::ptrdiff_t from = 0) {
  return {rows.row(from), rows.stride};
}

}  // namespace cairn
