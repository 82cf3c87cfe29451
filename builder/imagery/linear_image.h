#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "builder/imagery/texel_loops.h"
#include "builder/imagery/uninitialized_vector.h"

namespace cairn {

/// An image of linear texels, rows from the north.
class LinearImage {
 public:
  LinearImage() = default;
  /// Empty all over.
  LinearImage(int columns_, int rows_) : LinearImage(unset(columns_, rows_)) {
    std::fill(texels_.begin(), texels_.end(), LinearTexel{});
  }
  /// Without values: every texel is to be written.
  static LinearImage unset(int columns, int rows) {
    LinearImage image;
    image.columns = columns;
    image.rows = rows;
    image.stride_ = static_cast<std::size_t>(columns);
    image.texels_.resize(image.stride_ * static_cast<std::size_t>(rows));
    return image;
  }

  /// Whether it has any size.
  bool is_set() const { return !texels_.empty(); }

  const LinearTexel* row(int r) const {
    return texels_.data() + first_ + static_cast<std::size_t>(r) * stride_;
  }
  LinearTexel* row(int r) { return texels_.data() + first_ + static_cast<std::size_t>(r) * stride_; }

  /// Leaves `margin` texels away on each side. REQUIRES: some are left.
  void drop_margin(int margin) {
    first_ += static_cast<std::size_t>(margin) * (stride_ + 1);
    columns -= 2 * margin;
    rows -= 2 * margin;
    assert(columns > 0 && rows > 0);
  }

  int columns = 0;
  int rows = 0;

 private:
  UninitializedVector<LinearTexel> texels_;
  std::size_t stride_ = 0;  // texels from one row to the next, which are more than columns without a margin
  std::size_t first_ = 0;
};

/// The mean of two texels, halves rounded up; the order does not matter.
LinearTexel mean_of(const LinearTexel& a, const LinearTexel& b);

/// The image at half the size, each texel the mean of 2×2, halves rounded up. REQUIRES: even numbers of
/// columns and rows.
LinearImage halved(const LinearImage& image);

/// Whether no texel has any coverage.
bool is_empty(const LinearImage& image);

/// R, G, B in sRGB and alpha, 4 bytes a texel, not premultiplied; transparent texels are black.
struct SrgbImage {
  UninitializedVector<std::uint8_t> rgba;
  bool is_opaque = false;  ///< every alpha is 255
};
SrgbImage to_srgb(const LinearImage& image);

/// The same of a row of texels, to 4 bytes each. Returns whether every alpha is 255.
bool to_srgb(std::span<const LinearTexel> row, std::uint8_t* rgba);

}  // namespace cairn
