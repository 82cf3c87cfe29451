#include "builder/linear_image.h"

#include <algorithm>
#include <cassert>

#include "builder/srgb.h"

namespace cairn {

LinearTexel mean_of(const LinearTexel& a, const LinearTexel& b) {
  LinearTexel mean;
  for (std::size_t i = 0; i < 4; ++i) mean[i] = static_cast<std::uint16_t>((a[i] + b[i] + 1) / 2);
  return mean;
}

LinearTexel mean_of(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c, const LinearTexel& d) {
  LinearTexel mean;
  for (std::size_t i = 0; i < 4; ++i)
    mean[i] = static_cast<std::uint16_t>((a[i] + b[i] + c[i] + d[i] + 2) / 4);
  return mean;
}

LinearImage halved(const LinearImage& image) {
  assert(image.columns % 2 == 0 && image.rows % 2 == 0);
  LinearImage half(image.columns / 2, image.rows / 2);
  for (int r = 0; r < half.rows; ++r) {
    const LinearTexel* north = image.row(2 * r);
    const LinearTexel* south = image.row(2 * r + 1);
    LinearTexel* out = half.row(r);
    for (int c = 0; c < half.columns; ++c)
      out[c] = mean_of(north[2 * c], north[2 * c + 1], south[2 * c], south[2 * c + 1]);
  }
  return half;
}

LinearImage cropped(const LinearImage& image, int column, int row, int columns, int rows) {
  LinearImage part(columns, rows);
  for (int r = 0; r < rows; ++r) std::copy_n(image.row(row + r) + column, columns, part.row(r));
  return part;
}

bool is_empty(const LinearImage& image) {
  return std::all_of(image.texels.begin(), image.texels.end(),
                     [](const LinearTexel& t) { return t[3] == 0; });
}

std::vector<std::uint8_t> to_srgb(const LinearImage& image) {
  const auto& codes = srgb_of_linear();
  std::vector<std::uint8_t> rgba(4 * image.texels.size());
  std::uint8_t* out = rgba.data();
  for (const LinearTexel& texel : image.texels) {
    const std::uint32_t alpha = texel[3];
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t value = texel[i];
      if (alpha != 65535 && alpha != 0) value = std::min(65535u, (value * 65535u + alpha / 2) / alpha);
      out[i] = codes[value];
    }
    out[3] = static_cast<std::uint8_t>((alpha + 128) / 257);
    out += 4;
  }
  return rgba;
}

}  // namespace cairn
