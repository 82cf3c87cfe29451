#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "runtime/lod/lod_method.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/scene/focus_tile.h"
#include "runtime/scene/scene_map.h"
#include "cairn/bounding_volume.h"

namespace cairn {

/// The rules by which a scene's tiles are chosen.
struct SceneRules {
  RefinementPattern pattern = RefinementPattern::restricted;
  /// A visible area whose source's geometric error may project above this is split, as far as the pack has
  /// finer tiles, because no method can keep a tolerance that its tiles do not. 0 for the scene map alone.
  double refine_px = 0;
};

/// A part of the Earth where the pack has nothing finer than `source`.
struct FinestArea {
  TileId area;
  IndexEntry source;
  BoundingVolume volume;
};

/// The tiles of a pack as a Terrain would show them when all is loaded, without its threads. One thread.
class LabTerrain {
 public:
  explicit LabTerrain(std::shared_ptr<const PackReader> pack);

  const PackReader& pack() const { return contents_.pack(); }
  double lowest_m() const { return contents_.lowest_m(); }
  const std::vector<FinestArea>& finest() const { return finest_; }

  /// The camera's tile is kept over a flight's views with Terrain's hysteresis; forget_eye() begins anew.
  Result<LodScene> scene_for(const ViewState& view, const SceneRules& rules);
  void forget_eye() { eye_ = FocusTile(kTileMargin, kLevelMargin); }

  Result<std::shared_ptr<const HeightTile>> heights(const IndexEntry& entry);
  /// Returns the height of the finest surface, in metres; nullopt where the pack has none or it is void.
  Result<std::optional<double>> ground_m(LonLat place);

 private:
  static constexpr double kTileMargin = 0.125, kLevelMargin = 0.25;  // TerrainOptions' own

  void add_to_cover(const TileId& area, bool has_source, std::vector<TileId>& cover) const;
  std::vector<TileId> areas_for(const ViewState& view, RefinementPattern pattern);
  void refine(const TileId& area, const ViewState& view, double refine_px, std::vector<TileId>& out) const;
  void within_world(const TileId& area, std::vector<TileId>& out) const;
  bool has_finer(const TileId& area) const;
  void list_finest(const TileId& area);
  const BoundingVolume& volume_of(const TileId& area, const IndexEntry& source) const;
  Result<LodTile> load(const TileId& area, const IndexEntry& source);
  Result<std::shared_ptr<const std::vector<std::byte>>> flags(const TileId& id);

  TileAvailability contents_;
  Occluder occluder_;
  FocusTile eye_{kTileMargin, kLevelMargin};
  std::vector<FinestArea> finest_;
  std::unordered_map<TileId, std::shared_ptr<const HeightTile>> heights_;
  std::unordered_map<TileId, std::shared_ptr<const std::vector<std::byte>>> flags_;
  mutable std::unordered_map<TileId, BoundingVolume> volumes_;
};

}  // namespace cairn
