#pragma once

#include <cstdint>
#include <unordered_map>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Keeps what a method works out for each tile when it is loaded, for as long as the scene has the tile.
/// Entries are by the tile that has the heights. `Prepared` is constructed from (scene, tile,
/// between_samples) and has bytes(); between_samples says that places between the samples count, because the
/// tile stands for finer ones.
template <class Prepared>
class PreparedTiles {
 public:
  void prepare(const LodScene& scene) {
    std::unordered_map<TileId, bool> between_samples;
    for (const LodTile& tile : scene.tiles) between_samples[tile.source] |= tile.error_m > 0;
    std::erase_if(kept_, [&](const auto& item) {
      const auto needed = between_samples.find(item.first);
      return needed == between_samples.end() || needed->second != item.second.between_samples;
    });
    for (const LodTile& tile : scene.tiles) {
      if (kept_.contains(tile.source)) continue;
      const bool between = between_samples.at(tile.source);
      kept_.emplace(tile.source, Kept{between, Prepared(scene, tile, between)});
    }
  }

  const Prepared& of(const LodTile& tile) const { return kept_.at(tile.source).prepared; }

  std::uint64_t bytes() const {
    std::uint64_t bytes = 0;
    for (const auto& [source, kept] : kept_) bytes += kept.prepared.bytes();
    return bytes;
  }

 private:
  struct Kept {
    bool between_samples;
    Prepared prepared;
  };
  std::unordered_map<TileId, Kept> kept_;
};

}  // namespace cairn
