#include "runtime/pack_contents.h"

#include <algorithm>

namespace cairn {
namespace {

/// The index ascends by layer and level, so that the coarsest heights come first. A finer tile may go below
/// its ancestor by the ancestor's error.
double lowest_height_m(const PackReader& pack) {
  double lowest = 0;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::heights || entry.id.level != pack.entry(0).id.level) break;
    const double error = static_cast<double>(entry.geometric_error_m);
    lowest = std::min(lowest, entry.min_quanta * pack.header().quantum_m - error);
  }
  return std::max(lowest, -20000.0);  // deeper than any ground: a wrong error must not void the horizon
}

}  // namespace

PackContents::PackContents(std::shared_ptr<const PackReader> pack)
    : pack_(std::move(pack)),
      heights_(pack_->levels(Layer::heights)),
      imagery_(pack_->levels(Layer::imagery)),
      lowest_m_(lowest_height_m(*pack_)) {}

PackReader::LevelRange PackContents::levels() const {
  PackReader::LevelRange all{kMinLevel, kMinLevel};
  if (heights_) all.finest = std::max(all.finest, heights_->finest);
  if (imagery_) all.finest = std::max(all.finest, imagery_->finest);
  return all;
}

bool PackContents::has(Layer layer, const TileId& id) const {
  const auto& levels = range(layer);
  if (!levels || id.level < levels->coarsest || id.level > levels->finest) return false;
  return pack_->find_index(layer, id).has_value() && !damaged_.contains({layer, id});
}

std::optional<IndexEntry> PackContents::nearest(Layer layer, const TileId& id) const {
  const auto& levels = range(layer);
  if (!levels) return std::nullopt;
  for (int level = std::min(id.level, levels->finest); level >= levels->coarsest; --level) {
    const TileId ancestor = ancestor_of(id, level);
    if (has(layer, ancestor)) return pack_->find(layer, ancestor);
  }
  return std::nullopt;
}

double PackContents::ceiling_m(LonLat place) const {
  if (!heights_) return 0;
  const auto entry = pack_->find_nearest(Layer::heights, tile_at(place, heights_->finest));
  return entry ? entry->max_quanta * pack_->header().quantum_m : 0;
}

}  // namespace cairn
