#include "cairn/texture_tile.h"

#include <cassert>
#include <string>

#include "format/bytes.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

// Blocks repeat little: an earlier block's ends or indices, 4 bytes, and seldom more. To look for these costs
// three times as much as the rest of zstd's work and saves 8 % of the bytes (docs/imagery.md); so only longer
// ones are looked for. It decides bytes, so it never changes.
constexpr ZstdSearch kTexelSearch = {.level = 1, .hash_log = 14, .min_match = 6};

}  // namespace

std::size_t texture_image_bytes(TextureFormat format, int size) {
  const std::size_t blocks = (static_cast<std::size_t>(size) + 3) / 4;
  return blocks * blocks * (format == TextureFormat::bc1 ? 8 : 16);
}

std::size_t texture_chain_bytes(TextureFormat format, int size) {
  std::size_t bytes = 0;
  for (int side = size; side > 0; side /= 2) bytes += texture_image_bytes(format, side);
  return bytes;
}

std::vector<std::byte> encode_texture_block(const TextureTile& tile) {
  assert(tile.texels.size() == texture_chain_bytes(tile.format, tile.size));
  std::vector<std::byte> block;
  ByteWriter out(block);
  out.write(static_cast<std::uint8_t>(tile.format));
  out.write(std::uint8_t{0});
  out.write(std::uint16_t{0});
  append_zstd_frame(tile.texels, kTexelSearch, block);
  return block;
}

Result<TextureTile> decode_texture_block(std::span<const std::byte> block, int size) {
  ByteReader in(block);
  const auto format = in.read<std::uint8_t>();
  const auto reserved8 = in.read<std::uint8_t>();
  const auto reserved16 = in.read<std::uint16_t>();
  if (!in.ok()) {
    return bad_data("texture block: expected 4 bytes or more, found " + std::to_string(block.size()));
  }
  if (format != 1 && format != 3 && format != 7) {
    return bad_data("texture block: format: expected 1, 3 or 7, found " + std::to_string(format));
  }
  if (reserved8 != 0 || reserved16 != 0) {
    return bad_data("texture block: expected 0 in the reserved bytes, found others");
  }
  TextureTile tile{static_cast<TextureFormat>(format), size, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, size));
  const Status status = decode_zstd_frame(in.take(in.remaining()), tile.texels);
  if (!status) return bad_data("texture block: " + status.error().message);
  return tile;
}

}  // namespace cairn
