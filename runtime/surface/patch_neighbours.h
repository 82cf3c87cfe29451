#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/surface/surface_patch.h"

namespace cairn {

/// Finds patches by area.
class PatchIndex {
 public:
  explicit PatchIndex(std::span<const SurfacePatch> patches);

  /// Returns the patch that covers a tile: one of its level or a coarser one.
  std::optional<std::size_t> covering(TileId id) const;

 private:
  static constexpr std::uint32_t kSplit = 0xFFFFFFFFu;  // an area that patches are parts of
  struct Slot {
    TileId id{kMinLevel - 1, 0, 0};
    std::uint32_t patch = 0;
  };
  Slot& slot_of(const TileId& id);
  const Slot& slot_of(const TileId& id) const;

  std::vector<Slot> slots_;
  std::size_t mask_ = 0;
};

/// Returns the tile beyond a side; nullopt beyond the poles.
std::optional<TileId> beyond(const TileId& id, Side side);

/// Where two patches touch: `first` to `last` run over the latitude of a west or east side, the longitude of
/// a south or north side, in lattice units.
struct SharedSegment {
  std::size_t finer = 0;  ///< the patch of the finer level, or either of equal ones
  Side finer_side = Side::south;
  std::size_t coarser = 0;
  std::int64_t first = 0;
  std::int64_t last = 0;

  Side coarser_side() const { return opposite(finer_side); }
};

/// Returns every segment that two patches share, each once.
std::vector<SharedSegment> shared_segments(std::span<const SurfacePatch> patches);

/// Returns where a side of the area begins, in lattice units.
inline std::int64_t begin_of(const TileId& area, Side side) {
  const LatticePoint corner = south_west_of(area);
  return is_vertical(side) ? corner.y : corner.x;
}

}  // namespace cairn
