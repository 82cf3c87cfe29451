#include "tests/support/test_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <OpenImageIO/imagebuf.h>

namespace cairn::test {

TestImage landscape(int width, int height, double grain, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  TestImage image{width, height, {}};
  std::array<std::array<double, 4>, 24> waves;
  for (auto& [fx, fy, phase, height_of] : waves) {
    const double size = 3 + 60 * uniform();
    const double turn = 6.28 * uniform();
    fx = std::cos(turn) / size, fy = std::sin(turn) / size, phase = 6.28 * uniform(), height_of = size / 8;
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double channel[3] = {100, 110, 90};
      for (std::size_t w = 0; w < waves.size(); ++w) {
        const auto& [fx, fy, phase, height_of] = waves[w];
        const double wave = height_of * std::sin(x * fx + y * fy + phase);
        for (std::size_t c = 0; c < 3; ++c)
          channel[c] += w % 4 == c ? 1.5 * wave : w % 4 == 3 ? wave : 0.3 * wave;
      }
      for (const double value : channel) {
        const double grained = value + grain * (2 * uniform() - 1);
        image.rgba.push_back(static_cast<std::uint8_t>(std::clamp(grained, 0.0, 255.0)));
      }
      image.rgba.push_back(255);
    }
  }
  return image;
}

TestImage noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  TestImage image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height) * 4)};
  for (std::uint8_t& byte : image.rgba) byte = static_cast<std::uint8_t>(random() & 255);
  return image;
}

TestImage photo(const std::filesystem::path& path, int width, int height) {
  // Or a fourth band that is no alpha (near infrared) would be multiplied into the colours.
  OIIO::ImageSpec as_stored;
  as_stored["oiio:UnassociatedAlpha"] = 1;
  OIIO::ImageBuf file(path.string(), 0, 0, nullptr, &as_stored);
  if (!file.read(0, 0, true, OIIO::TypeDesc::UINT8) || file.nchannels() < 3) return {};
  TestImage image{std::min(width, file.spec().width), std::min(height, file.spec().height), {}};
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(image.width * image.height) * 3);
  file.get_pixels(OIIO::ROI(0, image.width, 0, image.height, 0, 1, 0, 3), OIIO::TypeDesc::UINT8, rgb.data());
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    image.rgba.insert(image.rgba.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 255});
  }
  return image;
}

double psnr_db(const TestImage& image, TextureFormat format, const std::vector<std::byte>& blocks,
               std::size_t first, std::size_t last) {
  std::vector<std::uint8_t> decoded(image.rgba.size());
  if (!decode_texture(format, blocks, image.width, image.height, decoded).ok()) return 0;
  double squares = 0;
  for (std::size_t i = 0; i < decoded.size(); i += 4) {
    for (std::size_t c = first; c < last; ++c) {
      const double off = static_cast<double>(decoded[i + c]) - image.rgba[i + c];
      squares += off * off;
    }
  }
  const double mean = squares / static_cast<double>(decoded.size() / 4 * (last - first));
  return mean == 0 ? std::numeric_limits<double>::infinity() : 10 * std::log10(255.0 * 255.0 / mean);
}

}  // namespace cairn::test
