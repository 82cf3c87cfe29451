#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cairn/pack_reader.h"
#include "cairn/status.h"
#include "cairn/terrain.h"
#include "runtime/lab/camera_path.h"

namespace cairn {

/// What a Terrain loads along a flight, one view each 0.1 s, each of which waits for its tiles.
struct FlightLoads {
  std::string flight;
  std::uint64_t tiles = 0;         ///< loaded, look-ahead included
  std::uint64_t bytes = 0;         ///< of their blocks, as stored
  std::uint64_t unseen_bytes = 0;  ///< of those, the ones of tiles that no view has seen
  std::uint64_t stale_tiles = 0;   ///< no longer wanted when they came
  std::uint64_t holes = 0;
  double error_px = 0;      ///< the largest screen error of the settled lists
  double texel_px = 0;      ///< the widest texel of theirs where the pack has finer ones
  bool is_limited = false;  ///< some list was short of memory
};

/// Flies a fresh Terrain along the path. The error is the Terrain's, or the first that a list reports.
Result<FlightLoads> loads_of(const std::shared_ptr<const PackReader>& pack, const CameraPath& path,
                             const TerrainOptions& options);

std::string flight_loads_header();
std::string to_row(const FlightLoads& loads);

}  // namespace cairn
