#include "builder/linear_image.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "builder/srgb.h"
#include "builder/texel_rows.h"

namespace cairn {

LinearTexel mean_of(const LinearTexel& a, const LinearTexel& b) {
  LinearTexel mean;
  for (std::size_t i = 0; i < 4; ++i) mean[i] = static_cast<std::uint16_t>((a[i] + b[i] + 1) / 2);
  return mean;
}

LinearImage halved(const LinearImage& image) {
  assert(image.columns % 2 == 0 && image.rows % 2 == 0);
  LinearImage half = LinearImage::unset(image.columns / 2, image.rows / 2);
  for (int r = 0; r < half.rows; ++r)
    texel_rows().halve(image.row(2 * r), image.row(2 * r + 1), static_cast<std::size_t>(half.columns),
                       half.row(r));
  return half;
}

bool is_empty(const LinearImage& image) {
  for (int r = 0; r < image.rows; ++r) {
    const LinearTexel* row = image.row(r);
    if (std::any_of(row, row + image.columns, [](const LinearTexel& t) { return t[3] != 0; })) return false;
  }
  return true;
}

SrgbImage to_srgb(const LinearImage& image) {
  const auto& codes = srgb_of_linear();
  const auto columns = static_cast<std::size_t>(image.columns);
  SrgbImage srgb{UnsetVector<std::uint8_t>(4 * columns * static_cast<std::size_t>(image.rows)), false};
  std::uint8_t* out = srgb.rgba.data();
  std::uint32_t all = ~0U;
  for (int r = 0; r < image.rows; ++r) {
    const LinearTexel* row = image.row(r);
    for (std::size_t c = 0; c < columns; ++c, out += 4) {
      LinearTexel texel = row[c];
      const std::uint32_t alpha = texel[3];
      if (alpha != 65535 && alpha != 0) {
        for (std::size_t i = 0; i < 3; ++i)
          texel[i] = static_cast<std::uint16_t>(std::min(65535U, (texel[i] * 65535U + alpha / 2) / alpha));
      }
      const std::uint32_t packed =
          static_cast<std::uint32_t>(codes[texel[0]] | codes[texel[1]] << 8 | codes[texel[2]] << 16) |
          (alpha + 128) / 257 << 24;
      std::memcpy(out, &packed, sizeof packed);
      all &= packed;
    }
  }
  srgb.is_opaque = all >> 24 == 255;
  return srgb;
}

}  // namespace cairn
