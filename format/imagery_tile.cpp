#include "format/imagery_tile.h"

#include <cassert>
#include <cstddef>
#include <span>

#include "cairn/texture_tile.h"
#include "format/block_texture.h"

namespace cairn {

Result<std::vector<std::uint8_t>> read_imagery_tile(const PackReader& pack, const IndexEntry& entry) {
  assert(entry.layer == Layer::imagery);
  const int side = pack.header().tile_size - 1;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 4);
  if ((entry.flags & kConstant) != 0) {
    const auto colour = static_cast<std::uint32_t>(entry.min_quanta);  // R in the lowest byte
    for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = static_cast<std::uint8_t>(colour >> i % 4 * 8);
    return rgba;
  }
  const auto block = pack.read_block(entry);
  if (!block) return block.error();
  const auto in_file = [&](const Error& error) {
    return Error{error.code,
                 pack.path().string() + ": imagery tile " + to_string(entry.id) + ": " + error.message};
  };
  const auto tile = decode_texture_block(*block, side);
  if (!tile) return in_file(tile.error());
  const auto finest = std::span(tile->texels).first(texture_image_bytes(tile->format, side));
  if (const Status status = decode_texture(tile->format, finest, side, side, rgba); !status)
    return in_file(status.error());
  return rgba;
}

}  // namespace cairn
