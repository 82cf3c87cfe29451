#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "cairn/pack_reader.h"
#include "cairn/read_tile.h"

namespace cairn {

/// The heights of a pack at any level, for what casts shadows; the last tiles stay in memory. Any thread may
/// call it.
class ShadowGround {
 public:
  explicit ShadowGround(std::shared_ptr<const PackReader> pack);

  const PackReader& pack() const { return *pack_; }
  /// Returns a height in metres that no ground exceeds.
  double highest_m() const { return highest_m_; }

  /// A tile of heights and where it lies.
  struct Tile {
    GeoBounds bounds;
    std::shared_ptr<const HeightTile> heights;  ///< null where the pack has none or it cannot be read
  };
  /// Returns the pack's tile, or its nearest ancestor.
  Tile find(const TileId& id);

 private:
  std::shared_ptr<const PackReader> pack_;
  double highest_m_ = 0;
  std::mutex mutex_;
  std::list<std::pair<TileId, std::shared_ptr<const HeightTile>>> tiles_;  // guarded by mutex_; latest first
};

/// Reads heights along a path, whose places mostly lie in the tile of the one before. One thread only.
class ShadowGroundReader {
 public:
  explicit ShadowGroundReader(ShadowGround& ground) : ground_(ground) {}

  /// Returns the height in metres, bilinear between the samples of the pack's tile of a level or of its
  /// nearest ancestor; NaN where there is none or it is void. Longitudes are any.
  double height_m(LonLat place, int level);

 private:
  ShadowGround& ground_;
  int level_ = kMaxLevel + 1;
  GeoBounds asked_;  // of the tile of this level that tile_ is for
  ShadowGround::Tile tile_;
};

}  // namespace cairn
