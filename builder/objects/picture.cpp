#include "builder/objects/picture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "builder/imagery/linear_image.h"
#include "builder/imagery/srgb.h"
#include "builder/texture_encode/texture_encode.h"

namespace cairn {
namespace {

LinearTexel linear_of(const std::uint8_t* rgba) {
  const double alpha = rgba[3] / 255.0;
  LinearTexel texel;
  for (std::size_t i = 0; i < 3; ++i) {
    const double light = static_cast<double>(linear_of_srgb()[rgba[i]]);
    texel[i] = static_cast<std::uint16_t>(std::lround(light * alpha));
  }
  texel[3] = static_cast<std::uint16_t>(std::lround(alpha * 65535));
  return texel;
}

LinearImage linear_image_of(const Picture& picture) {
  LinearImage image = LinearImage::unset(picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) image.row(y)[x] = linear_of(picture.at(x, y));
  return image;
}

Picture picture_of(const LinearImage& image) {
  const SrgbImage srgb = to_srgb(image);
  return {image.columns, image.rows, {srgb.rgba.begin(), srgb.rgba.end()}};
}

/// Which samples of a side of `from` a side of `to` has, and with what weight.
struct Tap {
  int sample = 0;
  double weight = 0;
};
std::vector<std::vector<Tap>> taps_of(int from, int to) {
  std::vector<std::vector<Tap>> all(static_cast<std::size_t>(to));
  const double step = static_cast<double>(from) / to;
  for (int t = 0; t < to; ++t) {
    const double low = t * step, high = low + step;
    for (int s = static_cast<int>(low); s < from && s < high; ++s) {
      const double covered = std::min<double>(high, s + 1) - std::max<double>(low, s);
      if (covered > 1e-9) all[static_cast<std::size_t>(t)].push_back({s, covered / step});
    }
  }
  return all;
}

}  // namespace

Picture Picture::filled(int width, int height, const std::uint8_t (&colour)[4]) {
  Picture picture{width, height, {}};
  const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (std::size_t i = 0; i < texels; ++i) picture.rgba.insert(picture.rgba.end(), colour, colour + 4);
  return picture;
}

Picture resized(const Picture& picture, int width, int height) {
  if (picture.width == width && picture.height == height) return picture;
  const LinearImage from = linear_image_of(picture);
  LinearImage to = LinearImage::unset(width, height);
  const auto across = taps_of(picture.width, width), down = taps_of(picture.height, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::array<double, 4> sum{};
      for (const Tap& v : down[static_cast<std::size_t>(y)])
        for (const Tap& h : across[static_cast<std::size_t>(x)])
          for (std::size_t i = 0; i < 4; ++i) sum[i] += v.weight * h.weight * from.row(v.sample)[h.sample][i];
      for (std::size_t i = 0; i < 4; ++i)
        to.row(y)[x][i] = static_cast<std::uint16_t>(std::clamp(std::lround(sum[i]), 0L, 65535L));
    }
  }
  return picture_of(to);
}

int power_of_two_within(int size, int least, int most) {
  const int power = static_cast<int>(std::bit_floor(static_cast<unsigned>(std::max(size, 1))));
  return std::clamp(power, least, most);
}

TextureTile texture_of(const Picture& picture, TextureFormat format) {
  assert(picture.width == picture.height && std::has_single_bit(static_cast<unsigned>(picture.width)));
  std::vector<Picture> mips;
  LinearImage image = linear_image_of(picture);
  mips.push_back(picture);
  while (mips.back().width > 1) {
    image = halved(image);
    mips.push_back(picture_of(image));
  }
  bool is_opaque = true;
  for (std::size_t m = mips.size(); m-- > 0;) {
    Picture& mip = mips[m];
    for (int y = 0; y < mip.height; ++y) {
      for (int x = 0; x < mip.width; ++x) {
        std::uint8_t* texel = mip.at(x, y);
        is_opaque = is_opaque && texel[3] == 255;
        if (texel[3] == 0 && m + 1 < mips.size()) std::memcpy(texel, mips[m + 1].at(x / 2, y / 2), 3);
      }
    }
  }
  if (format == TextureFormat::bc1 && !is_opaque) format = TextureFormat::bc3;
  TextureTile tile{format, picture.width, {}};
  for (const Picture& mip : mips)
    encode_texture(format, TextureQuality::normal, mip.rgba, mip.width, mip.height, tile.texels);
  return tile;
}

}  // namespace cairn
