#include "format/height_block.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>
#include <string>

#include "format/bytes.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

constexpr std::uint8_t kMaskFlag = 1;
constexpr int kMaskLevel = 9;  // masks are small and rare; the level decides bytes, so it never changes

std::size_t mask_bytes(std::size_t samples) {
  return (samples + 7) / 8;
}

std::vector<std::byte> pack_bits(const std::vector<std::uint8_t>& voids) {
  std::vector<std::byte> bits(mask_bytes(voids.size()));
  for (std::size_t i = 0; i < voids.size(); ++i) {
    if (voids[i] != 0) bits[i / 8] |= std::byte{1} << (i % 8);
  }
  return bits;
}

Status unpack_bits(std::span<const std::byte> bits, std::vector<std::uint8_t>& voids) {
  for (std::size_t i = 0; i < voids.size(); ++i) {
    voids[i] = static_cast<std::uint8_t>(bits[i / 8] >> (i % 8) & std::byte{1});
  }
  for (std::size_t i = voids.size(); i < bits.size() * 8; ++i) {
    if ((bits[i / 8] >> (i % 8) & std::byte{1}) != std::byte{0}) {
      return bad_data("void mask: expected 0 in the bits past the last sample, found 1");
    }
  }
  if (std::find(voids.begin(), voids.end(), 1) == voids.end()) {
    return bad_data("void mask: expected a void, found none");
  }
  return {};
}

Status read_mask(ByteReader& in, std::vector<std::uint8_t>& voids) {
  const auto length = in.read<std::uint32_t>();
  const auto frame = in.take(length);
  if (!in.ok()) return bad_data("void mask: expected " + std::to_string(length) + " bytes, found fewer");
  std::vector<std::byte> bits(mask_bytes(voids.size()));
  if (const Status status = decode_zstd_frame(frame, bits); !status) {
    return bad_data("void mask: " + status.error().message);
  }
  return unpack_bits(bits, voids);
}

/// The largest step that all samples are multiples of, voids' fillers too; 1 where that takes more than 16
/// bits, or all are 0.
std::uint16_t common_step(const std::vector<std::int32_t>& samples) {
  std::uint32_t step = 0;
  for (const std::int32_t sample : samples) {
    if (sample == 0) continue;
    step = std::gcd(
        step, sample < 0 ? 0u - static_cast<std::uint32_t>(sample) : static_cast<std::uint32_t>(sample));
    if (step == 1) break;
  }
  return step == 0 || step > std::numeric_limits<std::uint16_t>::max() ? std::uint16_t{1}
                                                                       : static_cast<std::uint16_t>(step);
}

std::vector<std::int32_t> in_steps(const std::vector<std::int32_t>& samples, std::int32_t step) {
  std::vector<std::int32_t> steps(samples.size());
  std::transform(samples.begin(), samples.end(), steps.begin(), [step](std::int32_t s) { return s / step; });
  return steps;
}

Status multiply(std::vector<std::int32_t>& samples, std::int32_t step) {
  if (step == 1) return {};
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  if (std::int64_t{*low} * step < kLeast || std::int64_t{*high} * step > kMost)
    return bad_data("height block: expected samples of 32 bits, found larger ones");
  for (std::int32_t& sample : samples) sample *= step;
  return {};
}

}  // namespace

std::vector<std::byte> encode_height_block(const HeightTile& tile, const HeightCodec& codec) {
  const bool has_voids = std::find(tile.voids.begin(), tile.voids.end(), 1) != tile.voids.end();
  std::vector<std::byte> block;
  ByteWriter out(block);
  out.write(codec.id);
  out.write(has_voids ? kMaskFlag : std::uint8_t{0});
  const std::uint16_t step = common_step(tile.samples);
  out.write(step);
  if (has_voids) {
    std::vector<std::byte> frame;
    append_zstd_frame(pack_bits(tile.voids), {.level = kMaskLevel}, frame);
    out.write(static_cast<std::uint32_t>(frame.size()));
    out.append(frame);
  }
  if (step == 1) {
    codec.encode(tile.samples, tile.size, block);
  } else {
    codec.encode(in_steps(tile.samples, step), tile.size, block);
  }
  return block;
}

Result<HeightTile> decode_height_block(std::span<const std::byte> block, int tile_size) {
  ByteReader in(block);
  const auto codec_id = in.read<std::uint8_t>();
  const auto flags = in.read<std::uint8_t>();
  const auto step = in.read<std::uint16_t>();
  if (!in.ok())
    return bad_data("height block: expected 4 bytes or more, found " + std::to_string(block.size()));
  const HeightCodec* codec = find_height_codec(codec_id);
  if (codec == nullptr) return bad_data("height block: no codec has the id " + std::to_string(codec_id));
  if ((flags & ~kMaskFlag) != 0) {
    return bad_data("height block: expected 0 in the reserved bits, found others");
  }
  if (step == 0) return bad_data("height block: expected a step of 1 or more, found 0");
  const std::size_t count = static_cast<std::size_t>(tile_size) * static_cast<std::size_t>(tile_size);
  HeightTile tile{tile_size, std::vector<std::int32_t>(count), {}};
  if ((flags & kMaskFlag) != 0) {
    tile.voids.resize(count);
    if (const Status status = read_mask(in, tile.voids); !status) return status.error();
  }
  Status status = codec->decode(in.take(in.remaining()), tile_size, tile.samples);
  if (status) status = multiply(tile.samples, step);
  if (!status) return status.error();
  return tile;
}

}  // namespace cairn
