#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/read_tile.h"
#include "cairn/surface.h"
#include "runtime/surface/surface_tile.h"

namespace cairn {

HeightTexels height_texels(const HeightTile& tile);

/// What is made of a tile of heights when it is loaded.
struct PreparedHeightTile {
  SurfaceTextures textures;
  SurfaceTile surface;
};
PreparedHeightTile prepare_heights(const TileId& id, std::shared_ptr<const HeightTile> tile, double quantum_m,
                                   const Ellipsoid& ellipsoid);

/// Prepares tiles where they are decoded, on the worker threads, and keeps the result until the renderer
/// takes it. Any thread may call any of it.
class PreparedHeights {
 public:
  void add(const TileId& id, std::shared_ptr<const HeightTile> tile, double quantum_m,
           const Ellipsoid& ellipsoid);

  /// The result for a tile, which is then forgotten; prepares it here if it is not there.
  PreparedHeightTile take(const TileId& id, std::shared_ptr<const HeightTile> tile, double quantum_m,
                          const Ellipsoid& ellipsoid);

  /// Drops what was prepared for a tile that is no longer in memory.
  void forget(const TileId& id);

 private:
  std::mutex mutex_;
  std::unordered_map<TileId, PreparedHeightTile> ready_;  // guarded by mutex_
};

}  // namespace cairn
