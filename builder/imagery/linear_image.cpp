#include "builder/imagery/linear_image.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "builder/imagery/srgb.h"

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
    texel_loops().halve(image.row(2 * r), image.row(2 * r + 1), static_cast<std::size_t>(half.columns),
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

static_assert(std::endian::native == std::endian::little);

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

// Without a way out of the loop, which then is a wide one.
bool all_opaque(std::span<const LinearTexel> row) {
  std::uint64_t all = ~std::uint64_t{0};
  for (const LinearTexel& linear : row) {
    std::uint64_t texel = 0;
    std::memcpy(&texel, &linear, sizeof texel);
    all &= texel;
  }
  return all >> 48 == 65535;
}

// Byte by byte: to put a texel's together first takes longer.
void opaque_to_srgb(std::span<const LinearTexel> row, const std::uint8_t* codes, std::uint8_t* rgba) {
  for (const LinearTexel& texel : row) {
    for (std::size_t k = 0; k < 3; ++k) rgba[k] = codes[texel[k]];
    rgba[3] = 255;
    rgba += 4;
  }
}

}  // namespace

bool to_srgb(std::span<const LinearTexel> row, std::uint8_t* rgba) {
  const std::uint8_t* codes = srgb_of_linear().data();
  if (all_opaque(row)) {
    opaque_to_srgb(row, codes, rgba);
    return true;
  }
  bool is_opaque = true;
  for (const LinearTexel& linear : row) {
    std::uint64_t texel = 0;
    std::memcpy(&texel, &linear, sizeof texel);
    texel = unmultiplied(texel);
    const auto alpha = static_cast<std::uint8_t>(((texel >> 48) + 128) / 257);
    is_opaque = is_opaque && alpha == 255;
    for (int k = 0; k < 3; ++k) rgba[k] = codes[texel >> 16 * k & 65535];
    rgba[3] = alpha;
    rgba += 4;
  }
  return is_opaque;
}

SrgbImage to_srgb(const LinearImage& image) {
  const auto columns = static_cast<std::size_t>(image.columns);
  SrgbImage srgb{UninitializedVector<std::uint8_t>(4 * columns * static_cast<std::size_t>(image.rows)), true};
  for (int r = 0; r < image.rows; ++r) {
    const bool is_opaque =
        to_srgb({image.row(r), columns}, &srgb.rgba[4 * columns * static_cast<std::size_t>(r)]);
    srgb.is_opaque = srgb.is_opaque && is_opaque;
  }
  return srgb;
}

}  // namespace cairn
