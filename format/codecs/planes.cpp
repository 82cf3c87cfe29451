// The simple peer: mixed second differences (a + b - c), zigzagged, split into byte planes, zstd. The inverse
// is a two-dimensional running sum, which compilers vectorise.
//
// Code: u8 planes (1..4), then one zstd frame that holds `planes` planes of size·size bytes, lowest byte
// first.

#include <bit>
#include <memory>

#include <zstd.h>

#include "format/codec.h"

namespace cairn {
namespace {

// The frame's own overhead is why fast level 1 is enough: higher levels gain nothing, the bits are in the
// prediction.
constexpr int kZstdLevel = 1;

std::uint32_t zigzag(std::uint32_t value) {
  return (value << 1) ^ (0u - (value >> 31));
}
std::uint32_t unzigzag(std::uint32_t value) {
  return (value >> 1) ^ (0u - (value & 1));
}

/// Writes the zigzagged mixed differences and returns the OR of them all. Samples outside count as 0.
std::uint32_t predict(std::span<const std::int32_t> samples, std::size_t size, std::uint32_t* residuals) {
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(samples[i]); };
  std::uint32_t seen = 0;
  for (std::size_t row = 0; row < size; ++row) {
    const std::size_t start = row * size;
    const auto rise = [&](std::size_t i) { return row == 0 ? at(i) : at(i) - at(i - size); };
    seen |= residuals[start] = zigzag(rise(start));
    for (std::size_t i = start + 1; i < start + size; ++i) {
      seen |= residuals[i] = zigzag(rise(i) - rise(i - 1));
    }
  }
  return seen;
}

void encode(std::span<const std::int32_t> samples, int size, std::vector<std::byte>& out) {
  const std::size_t count = samples.size();
  const auto residuals = std::make_unique_for_overwrite<std::uint32_t[]>(count);
  const std::uint32_t seen = predict(samples, static_cast<std::size_t>(size), residuals.get());
  const std::size_t planes = seen == 0 ? 1 : static_cast<std::size_t>(std::bit_width(seen) + 7) / 8;
  const auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(planes * count);
  for (std::size_t p = 0; p < planes; ++p) {
    for (std::size_t i = 0; i < count; ++i) {
      bytes[p * count + i] = static_cast<std::uint8_t>(residuals[i] >> (8 * p));
    }
  }
  const std::size_t start = out.size() + 1;
  out.push_back(static_cast<std::byte>(planes));
  out.resize(start + ZSTD_compressBound(planes * count));
  const std::size_t used =
      ZSTD_compress(out.data() + start, out.size() - start, bytes.get(), planes * count, kZstdLevel);
  assert(!ZSTD_isError(used));
  out.resize(start + used);
}

void undo_prediction(std::span<std::int32_t> samples, std::size_t size) {
  for (std::size_t row = 0; row < size; ++row) {
    std::uint32_t rise = 0;
    for (std::size_t i = row * size; i < (row + 1) * size; ++i) {
      rise += static_cast<std::uint32_t>(samples[i]);
      const std::uint32_t below = row == 0 ? 0 : static_cast<std::uint32_t>(samples[i - size]);
      samples[i] = static_cast<std::int32_t>(rise + below);
    }
  }
}

Status decode(std::span<const std::byte> code, int size, std::span<std::int32_t> samples) {
  const std::size_t count = samples.size();
  const std::size_t planes = code.empty() ? 0 : static_cast<std::size_t>(code[0]);
  if (planes < 1 || planes > 4) {
    return bad_data("planes height code: expected 1 to 4 planes, found " + std::to_string(planes));
  }
  const auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(planes * count);
  const std::size_t got = ZSTD_decompress(bytes.get(), planes * count, code.data() + 1, code.size() - 1);
  if (got != planes * count) {
    return bad_data("planes height code: expected " + std::to_string(planes * count) +
                    " bytes in it, found " +
                    (ZSTD_isError(got) ? ZSTD_getErrorName(got) : std::to_string(got)));
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t value = 0;
    for (std::size_t p = 0; p < planes; ++p) value |= std::uint32_t{bytes[p * count + i]} << (8 * p);
    samples[i] = static_cast<std::int32_t>(unzigzag(value));
  }
  undo_prediction(samples, static_cast<std::size_t>(size));
  return {};
}

}  // namespace

extern const HeightCodec planes_codec{1, "planes", encode, decode};

}  // namespace cairn
