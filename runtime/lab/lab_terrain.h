#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cairn/bounding_volume.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "runtime/lod/lod_method.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_selection.h"
#include "runtime/paging/tile_tree.h"
#include "runtime/scene/focus_tile.h"
#include "runtime/scene/scene_map.h"

namespace cairn {

/// The rules by which a scene's tiles are chosen: those of a Terrain, heights alone, without a budget.
struct SceneRules {
  RefinementPattern pattern = RefinementPattern::restricted;
  double refine_px = kTileShare;  ///< the screen error that the tiles may have; see SelectionRules
  bool with_ring = true;          ///< false leaves out the tiles around the camera that are outside the view
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

  const PackReader& pack() const { return contents_->pack(); }
  double lowest_m() const { return contents_->lowest_m(); }
  const std::vector<FinestArea>& finest() const { return finest_; }

  /// The camera's tile is kept over a flight's views with Terrain's hysteresis; forget_eye() begins anew.
  Result<LodScene> scene_for(const ViewState& view, const SceneRules& rules);
  void forget_eye() { eye_ = FocusTile(FocusTile::kTileMargin, FocusTile::kLevelMargin); }

  Result<std::shared_ptr<const HeightTile>> heights(const IndexEntry& entry);
  /// Returns the height of the finest surface, in metres; nullopt where the pack has none or it is void.
  Result<std::optional<double>> ground_m(LonLat place);

 private:
  /// An area of a scene, and the tile that shows it.
  struct SceneArea {
    TileId area;
    IndexEntry source;
  };
  std::vector<SceneArea> areas_for(const ViewState& view, const SceneRules& rules);
  void within_world(const TileId& area, std::vector<TileId>& out) const;
  bool has_finer(const TileId& area) const;
  void list_finest(const TileId& area);
  const BoundingVolume& volume_of(const TileId& area, const IndexEntry& source) const;
  double error_m_of(const TileId& area, const IndexEntry& source) const;
  Result<LodTile> load(const TileId& area, const IndexEntry& source);
  Result<std::shared_ptr<const std::vector<std::byte>>> flags(const TileId& id);

  std::unique_ptr<TileAvailability> contents_;  // stays where the tree knows it, when this is moved
  Occluder occluder_;
  TileTree tree_;
  FocusTile eye_{FocusTile::kTileMargin, FocusTile::kLevelMargin};
  std::vector<FinestArea> finest_;
  std::unordered_map<TileId, std::shared_ptr<const HeightTile>> heights_;
  std::unordered_map<TileId, std::shared_ptr<const std::vector<std::byte>>> flags_;
  mutable std::map<std::pair<TileId, TileId>, BoundingVolume> volumes_;  // by area and source
};

}  // namespace cairn
