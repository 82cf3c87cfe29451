#include "builder/export/mesh_export.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/pack_accuracy.h"

namespace cairn {

std::string name_of(const GeographicTile& tile) {
  return fmt::format("{}/{}/{}", tile.level, tile.x, tile.y);
}

std::string mesh_export_identity(const char* format, const PackReader& pack, const ExportOptions& options,
                                 VerticalDatum datum) {
  using Json = nlohmann::ordered_json;
  Json json = {{"format", format},
               {"pack", identity_of(pack)},
               {"datum", to_string(datum)},
               {"ellipsoidal", options.heights != ExportHeights::as_stored},
               {"geoid", options.geoid.string()}};
  if (options.region)
    json["region"] = {options.region->west, options.region->south, options.region->east,
                      options.region->north};
  if (options.max_error_m) json["max_error_m"] = *options.max_error_m;
  if (options.levels) json["finest"] = options.levels->finest;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<QuantizedMeshPlan> plan_mesh_export(const PackReader& pack, const PackPatches& patches,
                                           std::optional<double> finest_error_m, const ExportOptions& options,
                                           const VerticalShift& shift) {
  QuantizedMeshPlan::Options wanted{options.region, std::nullopt, options.max_error_m, bool(shift.metres)};
  if (options.levels) wanted.finest = options.levels->finest;
  return QuantizedMeshPlan::make(pack, patches, finest_error_m, wanted);
}

MetreTiles tiles_within_memory(const PackReader& pack, const ExportOptions& options,
                               std::size_t thread_bytes) {
  constexpr std::size_t kProgramBytes = std::size_t{64} << 20;
  const std::size_t tile_bytes =
      static_cast<std::size_t>(pack.header().tile_size) * pack.header().tile_size * sizeof(float);
  const std::size_t fixed = kProgramBytes + static_cast<std::size_t>(options.threads) * thread_bytes;
  const std::size_t spare = options.memory_bytes > fixed ? options.memory_bytes - fixed : 0;
  return MetreTiles(pack, std::max<std::size_t>(8, spare / tile_bytes));
}

Status report_parts(std::size_t done, Progress& now, const ProgressCallback& progress) {
  now.done = done;
  if (progress(now)) return {};
  return failed(fmt::format("export: cancelled after {} of {} parts", done, now.total));
}

}  // namespace cairn
