#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "builder/unset_vector.h"

namespace cairn {

/// One texel in linear light: R, G, B times alpha, and alpha, in steps of 1/65535. So averages need no
/// weights, and what is transparent never bleeds.
using LinearTexel = std::array<std::uint16_t, 4>;

/// An image of linear texels, rows from the north.
struct LinearImage {
  int columns = 0;
  int rows = 0;
  UnsetVector<LinearTexel> texels;

  LinearImage() = default;
  /// Empty all over.
  LinearImage(int columns_, int rows_)
      : columns(columns_),
        rows(rows_),
        texels(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), LinearTexel{}) {}
  /// Without values: every texel is to be written.
  static LinearImage unset(int columns, int rows) {
    LinearImage image;
    image.columns = columns;
    image.rows = rows;
    image.texels.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    return image;
  }

  const LinearTexel* row(int r) const {
    return texels.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
  LinearTexel* row(int r) {
    return texels.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
};

/// The mean of two texels, halves rounded up; the order does not matter.
LinearTexel mean_of(const LinearTexel& a, const LinearTexel& b);

/// The image at half the size, each texel the mean of 2×2, halves rounded up. REQUIRES: even numbers of
/// columns and rows.
LinearImage halved(const LinearImage& image);

/// The image without `margin` texels on each side. REQUIRES: some are left.
LinearImage without_margin(LinearImage&& image, int margin);

/// Whether no texel has any coverage, and whether all have all of it.
bool is_empty(const LinearImage& image);
bool is_opaque(const LinearImage& image);

/// R, G, B in sRGB and alpha, 4 bytes a texel, not premultiplied; transparent texels are black.
UnsetVector<std::uint8_t> to_srgb(const LinearImage& image);

}  // namespace cairn
