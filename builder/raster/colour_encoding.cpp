#include "builder/raster/colour_encoding.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace cairn {
namespace {

constexpr std::size_t kAlpha = 3;

unsigned load(SampleType type, const std::byte* at) {
  if (type == SampleType::uint8) return std::to_integer<unsigned>(*at);
  std::uint16_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint8_t to_8_bits(unsigned value, int bits) {
  if (bits == 8) return static_cast<std::uint8_t>(value);
  const unsigned most = (1u << bits) - 1;
  return static_cast<std::uint8_t>((std::min(value, most) * 255 + most / 2) / most);
}

std::uint8_t within_range(unsigned value, const std::pair<double, double>& range) {
  const double share = (static_cast<double>(value) - range.first) / (range.second - range.first);
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

void expand_opaque(const std::uint8_t* from, std::size_t stride, std::size_t count, std::uint8_t* rgba) {
  static_assert(std::endian::native == std::endian::little);
  std::size_t i = 0;
  // Four bytes at once, the last of which is the next pixel's.
  for (; i + 1 < count; ++i, from += stride, rgba += 4) {
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, from, sizeof pixel);
    pixel |= 0xFF000000U;
    std::memcpy(rgba, &pixel, sizeof pixel);
  }
  if (i == count) return;
  std::memcpy(rgba, from, 3);
  rgba[3] = 255;
}

}  // namespace

bool is_plain_rgb(const ColourEncoding& e) {
  return e.type == SampleType::uint8 && e.bits == 8 && e.channels == std::vector{0, 1, 2} && !e.alpha &&
         !e.white_is_zero && e.palette.empty() && !e.range;
}

std::optional<std::pair<double, double>> said_range(const SourceOverrides& said, int bits) {
  if (!said.black && !said.white) return std::nullopt;
  return std::pair{said.black.value_or(0), said.white.value_or((1 << bits) - 1)};
}

void expand_rgb(const ColourEncoding& encoding, const std::byte* samples, std::size_t stride,
                std::size_t count, std::uint8_t* rgba) {
  if (samples == nullptr) {
    std::memset(rgba, 0, 4 * count);
    return;
  }
  const auto* from = reinterpret_cast<const std::uint8_t*>(samples);
  const double nodata = encoding.nodata.value_or(-1);
  const bool has_nodata = nodata >= 0 && nodata <= 255 && nodata == std::floor(nodata);
  const auto absent = static_cast<std::uint8_t>(has_nodata ? nodata : 0);
  if (!has_nodata) return expand_opaque(from, stride, count, rgba);
  for (std::size_t i = 0; i < count; ++i, from += stride, rgba += 4) {
    const bool is_absent = from[0] == absent && from[1] == absent && from[2] == absent;
    rgba[0] = from[0];
    rgba[1] = from[1];
    rgba[2] = from[2];
    rgba[3] = is_absent ? 0 : 255;
  }
}

ColourAssembly::ColourAssembly(const ColourEncoding& encoding, std::span<std::uint8_t> rgba)
    : encoding_(encoding), rgba_(rgba), absent_(rgba.size() / 4) {
  assert(encoding.type == SampleType::uint8 || encoding.type == SampleType::uint16);
  for (std::size_t i = kAlpha; i < rgba.size(); i += 4) rgba[i] = 255;
}

void ColourAssembly::add(int channel, std::size_t first, std::size_t count, const std::byte* samples,
                         std::size_t stride) {
  const auto& channels = encoding_.channels;
  const auto colour = std::find(channels.begin(), channels.end(), channel);
  const bool is_alpha = encoding_.alpha == channel;
  if (colour == channels.end() && !is_alpha) return;
  const auto to = is_alpha ? kAlpha : static_cast<std::size_t>(colour - channels.begin());
  const double nodata = encoding_.nodata.value_or(std::nan(""));
  const bool indexed = !encoding_.palette.empty() && !is_alpha;
  const std::size_t step = stride * (encoding_.type == SampleType::uint16 ? 2 : 1);
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned value = samples == nullptr ? 0 : load(encoding_.type, samples + i * step);
    std::uint8_t byte = indexed                        ? static_cast<std::uint8_t>(value)
                        : encoding_.range && !is_alpha ? within_range(value, *encoding_.range)
                                                       : to_8_bits(value, encoding_.bits);
    if (encoding_.white_is_zero && !is_alpha) byte = static_cast<std::uint8_t>(255 - byte);
    rgba_[4 * (first + i) + to] = byte;
    const bool absent = samples == nullptr || value == nodata;
    if (!is_alpha && absent) ++absent_[first + i];
  }
}

void ColourAssembly::finish() {
  const auto& e = encoding_;
  for (std::size_t i = 0; i < absent_.size(); ++i) {
    std::uint8_t* pixel = rgba_.data() + 4 * i;
    if (!e.palette.empty()) {
      const std::size_t index = std::min<std::size_t>(pixel[0], e.palette.size() / 3 - 1);
      std::copy_n(e.palette.begin() + static_cast<std::ptrdiff_t>(3 * index), 3, pixel);
    } else if (e.channels.size() == 1) {
      pixel[1] = pixel[2] = pixel[0];
    }
    if (absent_[i] == e.channels.size()) pixel[kAlpha] = 0;
    if (e.premultiplied && pixel[kAlpha] != 0)
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] =
            static_cast<std::uint8_t>(std::min(255, (pixel[c] * 255 + pixel[kAlpha] / 2) / pixel[kAlpha]));
  }
}

}  // namespace cairn
