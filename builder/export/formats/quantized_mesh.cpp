#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/export_folder.h"
#include "builder/export/export_format.h"
#include "builder/export/mesh_export.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/quantized_mesh_file.h"
#include "builder/export/quantized_mesh_tile.h"
#include "builder/export/tile_ranges.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Unit = QuantizedMeshPlan::Unit;

constexpr std::size_t kThreadBytes = std::size_t{24} << 20;  // meshes and files of a unit
/// Tiles of every so many levels list those below them. CesiumJS stops at a metadata extension without that.
constexpr int kLevelsListed = 10;

struct MadeTile {
  GeographicTile tile;
  std::vector<std::byte> bytes;
};
struct MadeUnit {
  std::vector<MadeTile> tiles;
  ExportLevel level;
};

void add(const ExportLevel& part, ExportLevel& sum) {
  sum.level = part.level;
  sum.tiles += part.tiles;
  sum.bytes += part.bytes;
  sum.vertices += part.vertices;
  sum.triangles += part.triangles;
  sum.bound_m = std::max(sum.bound_m, part.bound_m);
  if (part.max_error_m <= sum.max_error_m && !sum.worst.empty()) return;
  sum.max_error_m = part.max_error_m;
  sum.worst = part.worst;
}

Json json_of(const ExportLevel& level) {
  return {{"level", level.level},
          {"tiles", level.tiles},
          {"bytes", level.bytes},
          {"vertices", level.vertices},
          {"triangles", level.triangles},
          {"bound_m", level.bound_m},
          {"max_error_m", level.max_error_m},
          {"worst", level.worst}};
}

ExportLevel level_of(const Json& json) {
  return {json.at("level"),     json.at("tiles"),   json.at("bytes"),       json.at("vertices"),
          json.at("triangles"), json.at("bound_m"), json.at("max_error_m"), json.at("worst")};
}

class QuantizedMeshExport {
 public:
  QuantizedMeshExport(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack), options_(options), progress_(progress), accuracy_(accuracy_of(pack)) {}

  Result<ExportReport> run();

 private:
  Status check() const;
  Result<MadeUnit> make(const QuantizedMeshSource& source, const Unit& unit) const;
  Status take(ExportFolder& folder, std::size_t i, MadeUnit&& made);
  Status finish(const QuantizedMeshPlan& plan, ExportFolder& folder, const ExportReport& report) const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  std::vector<Unit> units_;
  std::map<int, ExportLevel> levels_;
  Progress now_;
};

Status QuantizedMeshExport::check() const {
  if (options_.levels && options_.levels->coarsest != 0)
    return usage_error(
        fmt::format("levels: expected them from 0 on, since clients begin there, found {} to {}",
                    options_.levels->coarsest, options_.levels->finest));
  if (!pack_.levels(Layer::heights))
    return bad_data(pack_.path().string() + ": expected height tiles, found none");
  return {};
}

Result<MadeUnit> QuantizedMeshExport::make(const QuantizedMeshSource& source, const Unit& unit) const {
  MadeUnit made;
  made.level.level = unit.level;
  for (const GeographicTile& tile : source.plan.tiles_of(unit)) {
    auto mesh = make_quantized_mesh(source, tile);
    if (!mesh) return mesh.error();
    const double bound = source.plan.bound_m(tile);
    if (mesh->error_m > bound)
      return failed(
          fmt::format("tile {}: expected at most {:g} m off the source posts, found {:g} m after "
                      "rounding to its 32767 steps",
                      name_of(tile), bound, mesh->error_m));
    if (tile.level % kLevelsListed == 0) mesh->available = source.plan.below(tile, kLevelsListed);
    made.tiles.push_back({tile, encode_quantized_mesh(*mesh)});
    add({unit.level, 1, made.tiles.back().bytes.size(), mesh->u.size(), mesh->triangles.size(), bound,
         mesh->error_m, name_of(tile)},
        made.level);
  }
  return made;
}

Status QuantizedMeshExport::take(ExportFolder& folder, std::size_t i, MadeUnit&& made) {
  for (const MadeTile& tile : made.tiles)
    if (auto status = folder.write(name_of(tile.tile) + ".terrain", tile.bytes); !status) return status;
  if (made.level.tiles > 0) add(made.level, levels_[made.level.level]);
  Json line = json_of(made.level);
  line["unit"] = i;
  if (auto status = folder.append(line.dump()); !status) return status;
  now_.bytes_written += made.level.bytes;
  return report_parts(i + 1, now_, progress_);
}

Status QuantizedMeshExport::finish(const QuantizedMeshPlan& plan, ExportFolder& folder,
                                   const ExportReport& report) const {
  Json layer = {{"tilejson", "2.1.0"},
                {"name", pack_.path().stem().string()},
                {"version", "1.0.0"},
                {"format", "quantized-mesh-1.0"},
                {"scheme", "tms"},
                {"projection", "EPSG:4326"},
                {"tiles", Json::array({"{z}/{x}/{y}.terrain?v={version}"})},
                {"extensions", Json::array({"octvertexnormals", "metadata"})},
                {"metadataAvailability", kLevelsListed},
                {"minzoom", 0},
                {"maxzoom", plan.finest()},
                {"bounds", {-180, -90, 180, 90}}};
  std::vector<TileRanges> available(static_cast<std::size_t>(plan.finest()) + 1);
  for (const Unit& unit : units_)
    for (const GeographicTile& tile : plan.tiles_of(unit))
      available[static_cast<std::size_t>(tile.level)].add(tile.x, tile.y);
  layer["available"] = Json::array();
  for (const TileRanges& ranges : available) {
    Json level = Json::array();
    for (const TileRange& r : ranges.rectangles()) level.push_back(json_of(r));
    layer["available"].push_back(level);
  }
  while (layer["available"].size() > 1 && layer["available"].back().empty()) {
    layer["available"].erase(layer["available"].size() - 1);
    layer["maxzoom"] = layer["available"].size() - 1;
  }
  const auto text = [](const Json& json) {
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  };
  if (auto status = folder.write("layer.json", text(layer)); !status) return status;
  Json stated = {{"cairn", CAIRN_VERSION},
                 {"format", "quantized-mesh"},
                 {"pack", pack_.path().filename().string()},
                 {"vertical_datum", to_string(report.datum)},
                 {"levels", Json::array()}};
  for (const ExportLevel& level : report.levels) stated["levels"].push_back(json_of(level));
  if (auto status = folder.write("export.json", text(stated)); !status) return status;
  return folder.finish();
}

Result<ExportReport> QuantizedMeshExport::run() {
  if (auto status = check(); !status) return status.error();
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::ellipsoidal), options_.geoid);
  if (!shift) return shift.error();
  const PackPatches patches(pack_, accuracy_.finest_error_m);
  const auto plan = plan_mesh_export(pack_, patches, accuracy_.finest_error_m, options_, *shift);
  if (!plan) return plan.error();
  auto folder = ExportFolder::begin(
      options_.target, mesh_export_identity("quantized-mesh", pack_, options_, *datum), options_.resume);
  if (!folder) return folder.error();
  units_ = plan->units();
  now_.stage = "export";
  now_.total = units_.size();
  for (const std::string& line : folder->done()) {
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object() || json.value("unit", units_.size()) >= units_.size())
      return bad_data(options_.target.string() + ".part: journal: expected a finished part, found " + line);
    if (const ExportLevel level = level_of(json); level.tiles > 0) add(level, levels_[level.level]);
  }
  MetreTiles tiles = tiles_within_memory(pack_, options_, kThreadBytes);
  const QuantizedMeshSource source{*plan, patches, tiles, *shift};
  const Status made = make_mesh_units<MadeUnit>(
      units_, folder->done().size(), options_.threads, [&](const Unit& unit) { return make(source, unit); },
      [&](std::size_t i, MadeUnit&& unit) { return take(*folder, i, std::move(unit)); });
  if (!made) return made.error();
  ExportReport report;
  report.datum = shift->datum;
  for (const auto& [number, level] : levels_) report.levels.push_back(level);
  if (auto status = finish(*plan, *folder, report); !status) return status.error();
  return report;
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  return QuantizedMeshExport(pack, options, progress).run();
}

}  // namespace

extern const ExportFormat quantized_mesh_exporter;
const ExportFormat quantized_mesh_exporter{
    "quantized-mesh", "a folder of quantized-mesh tiles with layer.json, for CesiumJS and cesium-native",
    write};

}  // namespace cairn
