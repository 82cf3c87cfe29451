#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "builder/export/world_ticks.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// A height tile in metres above the pack's own datum; a void is NaN.
struct MetreTile {
  TileId id;
  int size = 0;
  bool has_voids = false;
  std::vector<float> metres;  ///< row-major, columns from west to east, rows from SOUTH to north

  float at(int column, int row) const {
    return metres[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                  static_cast<std::size_t>(column)];
  }

  /// Bilinear between the samples around the place; NaN where one that has weight is void. REQUIRES: the tile
  /// covers the place, edges included.
  double height_at(std::int64_t x, std::int64_t y) const;
};

/// Decoded height tiles of a pack, the latest used ones kept. Any number of threads may ask.
class MetreTiles {
 public:
  /// Keeps so many tiles at most. REQUIRES: the reader outlives this.
  MetreTiles(const PackReader& pack, std::size_t most_tiles);

  Result<std::shared_ptr<const MetreTile>> read(const IndexEntry& entry);

 private:
  using Kept = std::list<std::shared_ptr<const MetreTile>>;

  const PackReader& pack_;
  std::size_t most_tiles_;
  std::mutex mutex_;
  Kept kept_;  // the latest use first
  std::unordered_map<TileId, Kept::iterator> places_;
};

}  // namespace cairn
