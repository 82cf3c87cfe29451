#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/read_tile.h"
#include "runtime/surface/surface_tile.h"

namespace cairn::gl {

/// What the GPU takes of a tile of heights, and what the mesh needs to know of it.
struct HeightUpload {
  HeightTexels heights;
  std::vector<std::byte> normals;  ///< normal_map()
  TileRelief relief;
};
HeightUpload prepare_heights(const TileId& id, const HeightTile& tile, double quantum_m);

/// Prepares tiles where they are decoded, on the worker threads, and keeps the result until the renderer
/// takes it. Any thread may call any of it.
class PreparedHeights {
 public:
  /// `read`, with every tile of heights prepared before it is handed on. `this` must outlive what it returns.
  ReadTile preparing(ReadTile read, double quantum_m);

  /// The result for a tile, which is then forgotten; prepares it here if it is not there.
  HeightUpload take(const TileId& id, const HeightTile& tile, double quantum_m);

  /// Drops what was prepared for a tile that is no longer in memory.
  void forget(const TileId& id);

 private:
  std::mutex mutex_;
  std::unordered_map<TileId, HeightUpload> ready_;  // guarded by mutex_
};

}  // namespace cairn::gl
