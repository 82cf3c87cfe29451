#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <tbb/task_arena.h>

#include "builder/bake/pipeline.h"
#include "builder/export/export_format.h"
#include "builder/export/metre_tiles.h"
#include "builder/export/quantized_mesh_plan.h"
#include "builder/export/vertical_shift.h"

// What the exports of meshes in Cesium's geographic tiles share.

namespace cairn {

/// LEVEL/X/Y, which is the path of its file without an ending.
std::string name_of(const GeographicTile& tile);

/// Says what an unfinished export has to be of for a resumed one to go on with it.
std::string mesh_export_identity(const char* format, const PackReader& pack, const ExportOptions& options,
                                 VerticalDatum datum);

/// The tiles that the options ask for. usage where no level can keep its bound.
Result<QuantizedMeshPlan> plan_mesh_export(const PackReader& pack, const PackPatches& patches,
                                           std::optional<double> finest_error_m, const ExportOptions& options,
                                           const VerticalShift& shift);

/// The pack's decoded tiles, as many as the options' memory holds beside what each thread takes.
MetreTiles tiles_within_memory(const PackReader& pack, const ExportOptions& options,
                               std::size_t thread_bytes);

/// Says how far the export is. The error is `failed` where the callback cancels it.
Status report_parts(std::size_t done, Progress& now, const ProgressCallback& progress);

/// The finest level whose tiles may hold more than a hundred of the pack's.
inline constexpr int kLargeTileLevel = 6;

/// Makes the units from `done` on, on the options' threads, and hands them on in their order. Units
/// up to kLargeTileLevel are made one at a time.
template <class Made>
Status make_mesh_units(const std::vector<QuantizedMeshPlan::Unit>& units, std::size_t done, int threads,
                       const std::function<Result<Made>(const QuantizedMeshPlan::Unit&)>& make,
                       const std::function<Status(std::size_t, Made&&)>& take) {
  const auto large =
      static_cast<std::size_t>(std::find_if(units.begin(), units.end(),
                                            [](const auto& unit) { return unit.level > kLargeTileLevel; }) -
                               units.begin());
  const auto make_units = [&](std::size_t first, std::size_t end, std::size_t in_flight) {
    return run_in_order<Made>(
        first, end, in_flight, [&](std::size_t i) { return make(units[i]); }, take);
  };
  tbb::task_arena arena(threads);
  return arena.execute([&]() -> Status {
    if (auto status = make_units(std::min(done, large), large, 1); !status) return status;
    return make_units(std::max(done, large), units.size(), static_cast<std::size_t>(threads) + 1);
  });
}

}  // namespace cairn
