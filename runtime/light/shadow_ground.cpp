#include "runtime/light/shadow_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/view/ground_height.h"

namespace cairn {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostTiles = 64;  // in memory, about a MiB each

}  // namespace

ShadowGround::ShadowGround(std::shared_ptr<const PackReader> pack)
    : pack_(std::move(pack)), highest_m_(std::max(0.0, highest_ground_m(*pack_))) {}

ShadowGround::Tile ShadowGround::find(const TileId& id) {
  const auto entry = pack_->find_nearest(Layer::heights, id);
  if (!entry) return {};
  {
    const std::lock_guard lock(mutex_);
    const auto known =
        std::find_if(tiles_.begin(), tiles_.end(), [&](const auto& tile) { return tile.first == entry->id; });
    if (known != tiles_.end()) {
      tiles_.splice(tiles_.begin(), tiles_, known);
      return {tile_bounds(entry->id), tiles_.front().second};
    }
  }
  // Not under the lock: two threads may read one tile twice, but none waits for another's disk. The terrain
  // reports tiles that cannot be read.
  Result<HeightTile> read = pack_->read_height_tile(*entry);
  if (!read) return {tile_bounds(entry->id), nullptr};
  auto heights = std::make_shared<const HeightTile>(std::move(*read));
  const std::lock_guard lock(mutex_);
  tiles_.emplace_front(entry->id, heights);
  if (tiles_.size() > kMostTiles) tiles_.pop_back();
  return {tile_bounds(entry->id), std::move(heights)};
}

double ShadowGroundReader::height_m(LonLat place, int level) {
  place.lon -= 360 * std::floor((place.lon + 180) / 360);
  const bool inside = place.lon >= asked_.west && place.lon < asked_.east && place.lat >= asked_.south &&
                      place.lat < asked_.north;
  if (level != level_ || !inside) {
    const TileId id = tile_at(place, level);
    level_ = level;
    asked_ = tile_bounds(id);
    tile_ = ground_.find(id);
  }
  if (!tile_.heights) return kNone;
  const HeightTile& heights = *tile_.heights;
  const int cells = heights.size - 1;
  const double x = std::clamp((place.lon - tile_.bounds.west) / tile_.bounds.width(), 0.0, 1.0) * cells;
  const double y = std::clamp((place.lat - tile_.bounds.south) / tile_.bounds.height(), 0.0, 1.0) * cells;
  const int column = std::min(static_cast<int>(x), cells - 1), row = std::min(static_cast<int>(y), cells - 1);
  if (!heights.voids.empty() && (heights.is_void(column, row) || heights.is_void(column + 1, row) ||
                                 heights.is_void(column, row + 1) || heights.is_void(column + 1, row + 1))) {
    return kNone;
  }
  const double u = x - column, v = y - row;
  const double south = heights.at(column, row) * (1 - u) + heights.at(column + 1, row) * u;
  const double north = heights.at(column, row + 1) * (1 - u) + heights.at(column + 1, row + 1) * u;
  return (south * (1 - v) + north * v) * ground_.pack().header().quantum_m;
}

}  // namespace cairn
