#include "runtime/lab/flight_loads.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace cairn {
namespace {

constexpr double kFrame_s = 0.1;

/// Updates with the camera at rest until nothing is on the way, look-ahead included.
Result<const RenderList*> settle(Terrain& terrain, const ViewState& view) {
  const RenderList* list = &terrain.update(view, kFrame_s);
  for (;;) {
    if (!list->errors.empty()) return list->errors.front();
    if (list->is_settled && terrain.stats().in_flight_bytes == 0) return list;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    list = &terrain.update(view, 0);
  }
}

}  // namespace

Result<FlightLoads> loads_of(const std::shared_ptr<const PackReader>& pack, const CameraPath& path,
                             const TerrainOptions& options) {
  Result<Terrain> terrain = Terrain::open(pack, options);
  if (!terrain) return terrain.error();
  FlightLoads loads;
  loads.flight = path.name;
  for (const ViewState& view : path.views) {
    const Result<const RenderList*> list = settle(*terrain, view);
    if (!list) return list.error();
    loads.error_px = std::max(loads.error_px, (*list)->error_px);
    loads.texel_px = std::max(loads.texel_px, (*list)->texel_px);
    loads.is_limited = loads.is_limited || (*list)->is_limited;
  }
  const PagingStats stats = terrain->stats();
  loads.tiles = stats.tiles_loaded;
  loads.bytes = stats.bytes_loaded;
  loads.unseen_bytes = stats.bytes_unseen;
  loads.stale_tiles = stats.tiles_stale;
  loads.holes = stats.holes;
  return loads;
}

std::string flight_loads_header() {
  return "flight            tiles       MiB  unseen %   stale   holes   error px   texel px\n";
}

std::string to_row(const FlightLoads& loads) {
  constexpr double kMiB = 1024 * 1024;
  const double unseen =
      loads.bytes > 0 ? 100 * static_cast<double>(loads.unseen_bytes) / static_cast<double>(loads.bytes) : 0;
  char row[160];
  std::snprintf(
      row, sizeof row, "%-16s %6llu  %8.2f  %8.1f  %6llu  %6llu   %8.2f   %8.2f%s\n", loads.flight.c_str(),
      static_cast<unsigned long long>(loads.tiles), static_cast<double>(loads.bytes) / kMiB, unseen,
      static_cast<unsigned long long>(loads.stale_tiles), static_cast<unsigned long long>(loads.holes),
      loads.error_px, loads.texel_px, loads.is_limited ? "  limited by the cache" : "");
  return row;
}

}  // namespace cairn
