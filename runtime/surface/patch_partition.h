#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {

enum class Side { south, north, west, east };

/// Where two patches touch: `along` runs over the latitude of a west or east side, the longitude of a south
/// or north side, in lattice units.
struct SharedSegment {
  std::size_t finer = 0;  ///< the patch of the finer level, or either of equal ones
  Side finer_side = Side::south;
  std::size_t coarser = 0;
  std::int64_t along_first = 0;
  std::int64_t along_last = 0;

  Side coarser_side() const;
};

/// A part of an area, with what is known of it before its grid is chosen.
struct Patch {
  TileId area;
  std::size_t from = 0;
  ShownSurface surface;
  double distance_m = 0;  ///< from the eye to the nearest point, or less
  bool moves = false;
};

/// The areas, split until a grid of a block's size keeps the tolerance, and until neighbours differ by
/// kMaxLevelStep at most; without the parts that rules.inward hides.
std::vector<Patch> partition_areas(std::span<const MeshArea> areas, const MeshRules& rules);

/// Every segment that two patches share, each once.
std::vector<SharedSegment> shared_segments(std::span<const Patch> patches);

/// log2 of the cells along a side that keep the tolerance: of the decimated heights' deviation plus that of
/// the chords from the ellipsoid, R(δφ²+δλ²cos²φ)/8, the error of linear interpolation. Half the tolerance
/// where the patch moves.
int cells_log2_for_eye(const Patch& patch, const MeshRules& rules);

}  // namespace cairn::gl
