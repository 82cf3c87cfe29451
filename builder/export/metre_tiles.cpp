#include "builder/export/metre_tiles.h"

#include <algorithm>
#include <limits>

namespace cairn {

double MetreTile::height_at(std::int64_t x, std::int64_t y) const {
  const std::int64_t spacing = tile_ticks(id.level) / (size - 1);
  const TickRect rect = ticks_of(id);
  const int column = static_cast<int>(std::min<std::int64_t>((x - rect.west) / spacing, size - 2));
  const int row = static_cast<int>(std::min<std::int64_t>((y - rect.south) / spacing, size - 2));
  const double t = static_cast<double>(x - rect.west - column * spacing) / static_cast<double>(spacing);
  const double u = static_cast<double>(y - rect.south - row * spacing) / static_cast<double>(spacing);
  double sum = 0;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 2; ++c) {
      const double weight = (c == 0 ? 1 - t : t) * (r == 0 ? 1 - u : u);
      if (weight != 0) sum += weight * static_cast<double>(at(column + c, row + r));
    }
  }
  return sum;
}

MetreTiles::MetreTiles(const PackReader& pack, std::size_t most_tiles)
    : pack_(pack), most_tiles_(std::max<std::size_t>(most_tiles, 1)) {}

Result<std::shared_ptr<const MetreTile>> MetreTiles::read(const IndexEntry& entry) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = places_.find(entry.id); found != places_.end()) {
      kept_.splice(kept_.begin(), kept_, found->second);
      return kept_.front();
    }
  }
  const Result<HeightTile> tile = pack_.read_height_tile(entry);
  if (!tile) return tile.error();
  auto made = std::make_shared<MetreTile>();
  made->id = entry.id;
  made->size = tile->size;
  made->has_voids = !tile->voids.empty();
  made->metres.resize(tile->samples.size());
  const double quantum = pack_.header().quantum_m;
  for (std::size_t i = 0; i < tile->samples.size(); ++i)
    made->metres[i] = made->has_voids && tile->voids[i] != 0 ? std::numeric_limits<float>::quiet_NaN()
                                                             : static_cast<float>(tile->samples[i] * quantum);
  const std::lock_guard lock(mutex_);
  if (const auto found = places_.find(entry.id); found != places_.end()) return *found->second;
  while (kept_.size() >= most_tiles_) {
    places_.erase(kept_.back()->id);
    kept_.pop_back();
  }
  kept_.push_front(made);
  places_[entry.id] = kept_.begin();
  return kept_.front();
}

}  // namespace cairn
