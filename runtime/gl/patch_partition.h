#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/gl/mesh_plan.h"

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
  const SurfaceTile* surface = nullptr;
  double distance_m = 0;  ///< from the eye to the nearest point, or less
};

/// Chords this short are straight enough from anywhere.
inline constexpr double kNegligibleChord_m = 0.01;

/// The areas, split where the finest grid's chords are too long, and until neighbours differ by kMaxLevelStep
/// at most.
std::vector<Patch> partition_areas(std::span<const MeshArea> areas, const MeshRules& rules);

/// Every segment that two patches share, each once.
std::vector<SharedSegment> shared_segments(std::span<const Patch> patches);

/// How far, in metres, a grid's chords are from the ellipsoid where a side of the area has 2^cells_log2
/// cells: R(δφ²+δλ²cos²φ)/8, the error of linear interpolation.
double chord_deviation_m(const TileId& area, int cells_log2);

}  // namespace cairn::gl
