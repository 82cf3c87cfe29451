#include "builder/linear_image.h"

#include <algorithm>
#include <bit>
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

namespace {

// One texel with some transparency: R, G, B divided by alpha, and alpha, as 16-bit numbers from the lowest
// up.
std::uint64_t unmultiplied(std::uint64_t texel) {
  const std::uint64_t alpha = texel >> 48;
  if (alpha == 0) return texel;
  std::uint64_t plain = alpha << 48;
  for (int shift = 0; shift < 48; shift += 16)
    plain |= std::min<std::uint64_t>(65535, ((texel >> shift & 65535) * 65535 + alpha / 2) / alpha) << shift;
  return plain;
}

}  // namespace

SrgbImage to_srgb(const LinearImage& image) {
  static_assert(std::endian::native == std::endian::little);
  const std::uint8_t* codes = srgb_of_linear().data();
  const auto columns = static_cast<std::size_t>(image.columns);
  SrgbImage srgb{UnsetVector<std::uint8_t>(4 * columns * static_cast<std::size_t>(image.rows)), true};
  std::uint8_t* out = srgb.rgba.data();
  for (int r = 0; r < image.rows; ++r) {
    const LinearTexel* row = image.row(r);
    for (std::size_t c = 0; c < columns; ++c, out += 4) {
      std::uint64_t texel = 0;
      std::memcpy(&texel, row + c, sizeof texel);
      std::uint32_t alpha = 255;
      if (texel >> 48 != 65535) {
        texel = unmultiplied(texel);
        alpha = static_cast<std::uint32_t>(((texel >> 48) + 128) / 257);
        srgb.is_opaque = srgb.is_opaque && alpha == 255;
      }
      const std::uint32_t red = codes[texel & 65535], green = codes[texel >> 16 & 65535],
                          blue = codes[texel >> 32 & 65535];
      const std::uint32_t packed = red | green << 8 | blue << 16 | alpha << 24;
      std::memcpy(out, &packed, sizeof packed);
    }
  }
  return srgb;
}

}  // namespace cairn
