#include "runtime/paging/tile_availability.h"

#include <algorithm>
#include <vector>

namespace cairn {
namespace {

// The tiles of a layer's coarsest level.
std::vector<IndexEntry> coarsest_tiles(const PackReader& pack, Layer layer) {
  std::vector<IndexEntry> tiles;
  std::size_t begin = 0;
  for (const PackLevel& level : pack.level_table()) {
    const auto count = static_cast<std::size_t>(level.tiles);
    for (std::size_t i = begin; level.layer == layer && i < begin + count; ++i)
      tiles.push_back(pack.entry(i));
    if (level.layer == layer) break;
    begin += count;
  }
  return tiles;
}

}  // namespace

TileAvailability::TileAvailability(std::shared_ptr<const PackReader> pack, const TileTable* table)
    : pack_(std::move(pack)),
      table_(table),
      heights_(pack_->levels(Layer::heights)),
      imagery_(pack_->levels(Layer::imagery)),
      objects_(pack_->levels(Layer::objects)) {
  for (const IndexEntry& tile : coarsest_tiles(*pack_, Layer::heights)) {
    // A finer tile may go below its ancestor by the ancestor's error.
    const double error = static_cast<double>(tile.geometric_error_m);
    lowest_m_ = std::min(lowest_m_, tile.min_quanta * pack_->header().quantum_m - error);
    note_ancestors(tile.id);
  }
  for (const IndexEntry& tile : coarsest_tiles(*pack_, Layer::imagery)) note_ancestors(tile.id);
  lowest_m_ =
      std::max(lowest_m_, -20000.0);  // deeper than any ground: a wrong error must not void the horizon
}

void TileAvailability::note_ancestors(TileId id) {
  while (id.level > kMinLevel && above_.insert(parent_of(id)).second) id = parent_of(id);
}

PackReader::LevelRange TileAvailability::levels() const {
  PackReader::LevelRange all{kMinLevel, kMinLevel};
  if (heights_) all.finest = std::max(all.finest, heights_->finest);
  if (imagery_) all.finest = std::max(all.finest, imagery_->finest);
  return all;
}

bool TileAvailability::has(Layer layer, const TileId& id) const {
  const auto& levels = range(layer);
  if (!levels || id.level < levels->coarsest || id.level > levels->finest) return false;
  return pack_->find_index(layer, id).has_value() && !(table_ && is_absent(table_->state({layer, id})));
}

std::optional<IndexEntry> TileAvailability::nearest(Layer layer, const TileId& id) const {
  const auto& levels = range(layer);
  if (!levels) return std::nullopt;
  for (int level = std::min(id.level, levels->finest); level >= levels->coarsest; --level) {
    const TileId ancestor = ancestor_of(id, level);
    if (has(layer, ancestor)) return pack_->find(layer, ancestor);
  }
  return std::nullopt;
}

double TileAvailability::ceiling_m(LonLat place) const {
  if (!heights_) return 0;
  const auto entry = pack_->find_nearest(Layer::heights, tile_at(place, heights_->finest));
  return entry ? entry->max_quanta * pack_->header().quantum_m : 0;
}

}  // namespace cairn
