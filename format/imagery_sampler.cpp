#include "format/imagery_sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "format/imagery_tile.h"

namespace cairn {

struct ImagerySampler::State {
  struct Cached {
    TileId id;
    std::vector<std::uint8_t> rgba;
  };

  Result<const Cached*> nearest_tile(const TileId& id);

  const PackReader* reader;
  std::size_t most_tiles;
  std::vector<Cached> cache;    // latest use first
  std::optional<TileId> asked;  // last, and what came of it: neighbouring places ask for one tile
  bool is_found = false;        // then it is the first of the cache
};

/// The tile or its nearest ancestor, decoded; null where there is neither.
Result<const ImagerySampler::State::Cached*> ImagerySampler::State::nearest_tile(const TileId& id) {
  if (asked == id) return is_found ? &cache.front() : nullptr;
  asked.reset();
  const auto entry = reader->find_nearest(Layer::imagery, id);
  is_found = entry.has_value();
  if (entry) {
    const auto hit = std::find_if(cache.begin(), cache.end(),
                                  [&](const Cached& cached) { return cached.id == entry->id; });
    if (hit != cache.end()) {
      std::rotate(cache.begin(), hit, hit + 1);
    } else {
      auto rgba = read_imagery_tile(*reader, *entry);
      if (!rgba) return rgba.error();
      if (cache.size() == most_tiles) cache.pop_back();
      cache.insert(cache.begin(), Cached{entry->id, *std::move(rgba)});
    }
  }
  asked = id;
  return is_found ? &cache.front() : nullptr;
}

ImagerySampler::ImagerySampler(const PackReader& reader, std::size_t cached_tiles)
    : state_(new State{&reader, cached_tiles, {}, {}, false}) {
  assert(cached_tiles >= 1);
}

ImagerySampler::~ImagerySampler() = default;
ImagerySampler::ImagerySampler(ImagerySampler&&) noexcept = default;

Result<ImagerySampler::Colour> ImagerySampler::colour_at(LonLat place, int finest) {
  const auto range = state_->reader->levels(Layer::imagery);
  if (!range || !std::isfinite(place.lon) || !(std::abs(place.lat) <= 90)) return Colour{};
  const TileId id = tile_at(place, std::min(finest, range->finest));
  const auto tile = state_->nearest_tile(id);
  if (!tile) return tile.error();
  if (*tile == nullptr) return Colour{};
  const GeoBounds bounds = tile_bounds((*tile)->id);
  const int side = state_->reader->header().tile_size - 1;
  const double scale = side / bounds.width();
  double east = std::fmod(place.lon - bounds.west, 360.0);
  if (east < 0) east += 360.0;
  const auto index = [side](double at) { return std::clamp(static_cast<int>(at), 0, side - 1); };
  const auto column = static_cast<std::size_t>(index(east * scale));
  const auto row = static_cast<std::size_t>(side - 1 - index((place.lat - bounds.south) * scale));
  Colour colour;
  std::memcpy(colour.data(), (*tile)->rgba.data() + (row * static_cast<std::size_t>(side) + column) * 4, 4);
  return colour;
}

}  // namespace cairn
