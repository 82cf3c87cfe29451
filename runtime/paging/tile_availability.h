#pragma once

#include <memory>
#include <optional>
#include <unordered_set>

#include "cairn/loaded_tile.h"
#include "cairn/pack_reader.h"
#include "runtime/paging/tile_table.h"

namespace cairn {

/// What a pack has to show: the tiles of its index, less those found to be damaged and, for a while, those
/// whose reads fail. One thread only.
class TileAvailability {
 public:
  /// `table`, which must outlive it, says which tiles are absent; null: none are.
  explicit TileAvailability(std::shared_ptr<const PackReader> pack, const TileTable* table = nullptr);

  const PackReader& pack() const { return *pack_; }
  const std::shared_ptr<const PackReader>& shared_pack() const { return pack_; }
  bool has_imagery() const { return imagery_.has_value(); }
  /// Over the layers that are drawn; -9 and -9 where the pack is empty.
  PackReader::LevelRange levels() const;

  /// Whether the tile can be had in the layer.
  bool has(Layer layer, const TileId& id) const;
  /// Whether the tile shows something of its own: heights or imagery.
  bool shows(const TileId& id) const { return has(Layer::heights, id) || has(Layer::imagery, id); }
  /// The tile itself or its nearest ancestor that can be had.
  std::optional<IndexEntry> nearest(Layer layer, const TileId& id) const;

  /// Whether the area, which has no tile of its own nor an ancestor that has, has tiles of the pack in it:
  /// the coarsest level of a pack is often 0.
  bool is_above_tiles(const TileId& area) const { return above_.contains(area); }

  /// A height, in metres, that no ground of the finest tile at the place exceeds, from the index alone, so
  /// that it does not depend on what is loaded. 0 where there is no tile.
  double ceiling_m(LonLat place) const;
  /// A height that no ground of the pack is below, from its coarsest level.
  double lowest_m() const { return lowest_m_; }

 private:
  const std::optional<PackReader::LevelRange>& range(Layer layer) const {
    return layer == Layer::heights ? heights_ : layer == Layer::objects ? objects_ : imagery_;
  }
  void note_ancestors(TileId id);

  std::shared_ptr<const PackReader> pack_;
  const TileTable* table_;
  std::optional<PackReader::LevelRange> heights_;
  std::optional<PackReader::LevelRange> imagery_;
  std::optional<PackReader::LevelRange> objects_;
  std::unordered_set<TileId> above_;  // the ancestors of the coarsest tiles, which the pack does not have
  double lowest_m_ = 0;
};

}  // namespace cairn
