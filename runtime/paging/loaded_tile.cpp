#include "cairn/loaded_tile.h"

#include <algorithm>
#include <cstddef>

namespace cairn {
namespace {

// The tile object and its reference counts; and allocators give large blocks in whole pages.
constexpr std::uint64_t kObjectBytes = 512 + 4096;

}  // namespace

std::uint64_t LoadedTile::bytes() const {
  std::uint64_t bytes = kObjectBytes;
  if (heights) bytes += heights->samples.capacity() * sizeof(std::int32_t) + heights->voids.capacity();
  if (texture) bytes += texture->texels.capacity();
  if (objects) bytes += objects->objects.capacity() * sizeof(PlacedObject);
  if (standing) bytes += standing->bytes();
  return bytes;
}

std::uint64_t decoded_bytes_bound(const IndexEntry& entry, int tile_size) {
  const auto side = static_cast<std::uint64_t>(tile_size);
  if (entry.layer == Layer::heights) {
    const std::uint64_t voids = (entry.flags & kHasVoids) != 0 ? 1 : 0;
    return kObjectBytes + side * side * (sizeof(std::int32_t) + voids);
  }
  if (entry.layer == Layer::objects) {
    return kObjectBytes + LoadedObjects::bytes_bound(static_cast<std::size_t>(std::max(entry.min_quanta, 0)));
  }
  return kObjectBytes + texture_chain_bytes(TextureFormat::bc7, tile_size - 1);
}

}  // namespace cairn
