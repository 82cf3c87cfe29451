#include "builder/export/webp_picture.h"

#include <cmath>
#include <memory>

#include <webp/decode.h>
#include <webp/encode.h>

namespace cairn {
namespace {

constexpr float kQuality = 90;

struct Freed {
  void operator()(std::uint8_t* bytes) const { WebPFree(bytes); }
};
using WebpBytes = std::unique_ptr<std::uint8_t, Freed>;

double colour_rms(std::span<const std::uint8_t> rgba, const std::uint8_t* decoded) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    if (rgba[i + 3] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k) sum += std::pow(static_cast<double>(rgba[i + k]) - decoded[i + k], 2);
    count += 3;
  }
  return count == 0 ? 0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

Result<WebpPicture> encode_webp(std::span<const std::uint8_t> rgba, int side) {
  std::uint8_t* encoded = nullptr;
  const std::size_t size = WebPEncodeRGBA(rgba.data(), side, side, 4 * side, kQuality, &encoded);
  const WebpBytes owner(encoded);
  if (size == 0) return failed("WebP: expected room to compress a picture, found none");
  int width = 0, height = 0;
  const WebpBytes decoded(WebPDecodeRGBA(encoded, size, &width, &height));
  if (!decoded) return failed("WebP: expected a picture that can be read back, found none");
  const auto* bytes = reinterpret_cast<const std::byte*>(encoded);
  return WebpPicture{{bytes, bytes + size}, colour_rms(rgba, decoded.get())};
}

}  // namespace cairn
