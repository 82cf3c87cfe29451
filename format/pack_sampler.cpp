#include "cairn/pack_sampler.h"

#include <algorithm>
#include <cmath>

#include "format/ground_sampler.h"

namespace cairn {

struct PackSampler::State {
  const PackReader* reader;
  GroundSampler ground;
};

PackSampler::PackSampler(const PackReader& reader, std::size_t cached_tiles)
    : state_(new State{
          &reader,
          GroundSampler({[&reader](const TileId& id) { return reader.find(Layer::heights, id); },
                         [&reader](const IndexEntry& entry) { return reader.read_height_tile(entry); },
                         reader.header().tile_size},
                        cached_tiles)}) {}

PackSampler::~PackSampler() = default;
PackSampler::PackSampler(PackSampler&&) noexcept = default;

Result<std::optional<PackSampler::Height>> PackSampler::height_at(LonLat place, int finest, int coarsest) {
  using Answer = std::optional<Height>;
  const PackReader& reader = *state_->reader;
  const auto range = reader.levels(Layer::heights);
  if (!range || !std::isfinite(place.lon) || !(std::abs(place.lat) <= 90)) return Answer();
  finest = std::min(finest, range->finest);
  coarsest = std::max(coarsest, range->coarsest);
  if (finest < coarsest) return Answer();
  const auto height = state_->ground.height_at(place, finest, coarsest);
  if (!height) return height.error();
  if (!*height) return Answer();
  const IndexEntry& tile = (*height)->tile;
  return Answer(Height{(*height)->quanta * reader.header().quantum_m, tile.id.level, tile.geometric_error_m});
}

}  // namespace cairn
