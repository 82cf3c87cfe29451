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

LinearImage without_margin(LinearImage&& image, int margin) {
  LinearImage inner;
  inner.columns = image.columns - 2 * margin;
  inner.rows = image.rows - 2 * margin;
  assert(inner.columns > 0 && inner.rows > 0);
  inner.texels = std::move(image.texels);
  LinearTexel* to = inner.texels.data();
  for (int r = 0; r < inner.rows; ++r, to += inner.columns)
    std::copy_n(inner.texels.data() + (r + margin) * image.columns + margin, inner.columns, to);
  inner.texels.resize(static_cast<std::size_t>(inner.columns) * static_cast<std::size_t>(inner.rows));
  return inner;
}

bool is_empty(const LinearImage& image) {
  return std::all_of(image.texels.begin(), image.texels.end(),
                     [](const LinearTexel& t) { return t[3] == 0; });
}

// Without a way out of the loop, which then is a wide one.
bool is_opaque(const LinearImage& image) {
  std::uint16_t all = 65535;
  for (const LinearTexel& texel : image.texels) all &= texel[3];
  return all == 65535;
}

UnsetVector<std::uint8_t> to_srgb(const LinearImage& image) {
  const auto& codes = srgb_of_linear();
  UnsetVector<std::uint8_t> rgba(4 * image.texels.size());
  std::uint8_t* out = rgba.data();
  for (LinearTexel texel : image.texels) {
    const std::uint32_t alpha = texel[3];
    if (alpha != 65535 && alpha != 0) {
      for (std::size_t i = 0; i < 3; ++i)
        texel[i] = static_cast<std::uint16_t>(std::min(65535u, (texel[i] * 65535u + alpha / 2) / alpha));
    }
    const std::uint32_t packed =
        static_cast<std::uint32_t>(codes[texel[0]] | codes[texel[1]] << 8 | codes[texel[2]] << 16) |
        (alpha + 128) / 257 << 24;
    std::memcpy(out, &packed, sizeof packed);
    out += 4;
  }
  return rgba;
}

}  // namespace cairn
