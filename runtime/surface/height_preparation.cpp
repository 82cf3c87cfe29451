#include "runtime/surface/height_preparation.h"

#include <utility>

#include "runtime/surface/normal_map.h"

namespace cairn::gl {

HeightUpload prepare_heights(const TileId& id, const HeightTile& tile, double quantum_m) {
  return {height_texels(tile), normal_map(id, tile, quantum_m), relief_of(tile, quantum_m)};
}

ReadTile PreparedHeights::preparing(ReadTile read, double quantum_m) {
  return [this, read = std::move(read), quantum_m](const IndexEntry& entry) {
    Result<LoadedTile> tile = read(entry);
    if (tile && tile->heights) {
      HeightUpload upload = prepare_heights(entry.id, *tile->heights, quantum_m);
      const std::lock_guard lock(mutex_);
      ready_.insert_or_assign(entry.id, std::move(upload));
    }
    return tile;
  };
}

HeightUpload PreparedHeights::take(const TileId& id, const HeightTile& tile, double quantum_m) {
  {
    const std::lock_guard lock(mutex_);
    if (auto node = ready_.extract(id)) return std::move(node.mapped());
  }
  return prepare_heights(id, tile, quantum_m);
}

void PreparedHeights::forget(const TileId& id) {
  const std::lock_guard lock(mutex_);
  ready_.erase(id);
}

}  // namespace cairn::gl
