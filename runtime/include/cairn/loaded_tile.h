#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <memory>

#include "cairn/height_tile.h"
#include "cairn/loaded_objects.h"
#include "cairn/pack_layout.h"
#include "cairn/texture_tile.h"

namespace cairn {

/// Identifies a tile of a pack: its layer and address.
struct TileKey {
  Layer layer = Layer::heights;
  TileId id;

  friend auto operator<=>(const TileKey&, const TileKey&) = default;
};

inline TileKey key_of(const IndexEntry& entry) {
  return {entry.layer, entry.id};
}

/// A decoded tile. Immutable: any thread may read it for as long as it keeps the pointer.
struct LoadedTile {
  std::shared_ptr<const HeightTile> heights;            ///< of Layer::heights, else null
  std::shared_ptr<const TextureTile> texture;           ///< of Layer::imagery, else null
  std::shared_ptr<const ObjectTile> objects = nullptr;  ///< of Layer::objects as read, else null
  /// Of Layer::objects with the models, which the Terrain adds; then `objects` is null.
  std::shared_ptr<const LoadedObjects> standing = nullptr;

  /// Returns the bytes of memory that its vectors have allocated.
  std::uint64_t bytes() const;
};

/// Returns the most bytes of memory that the decoded tile can take, before it is read.
std::uint64_t decoded_bytes_bound(const IndexEntry& entry, int tile_size);

}  // namespace cairn

template <>
struct std::hash<cairn::TileKey> {
  std::size_t operator()(const cairn::TileKey& key) const noexcept {
    return std::hash<cairn::TileId>{}(key.id) * 31 + static_cast<std::size_t>(key.layer);
  }
};
