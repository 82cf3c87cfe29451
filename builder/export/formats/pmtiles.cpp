// MapLibre raster-dem tiles in one PMTiles archive.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/pack_accuracy.h"
#include "builder/export/pmtiles_export.h"
#include "builder/export/raster_dem_tile.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSamplerTiles = 12;  // of a thread
constexpr std::size_t kProgramBytes = std::size_t{48} << 20;
constexpr std::size_t kThreadBytes = std::size_t{36} << 20;
/// Tiles are measured at the samples of so many levels below their own, and those tiles' errors are added.
constexpr int kMeasuredLevels = 3;

/// The ticks within bounds, which may lie outside the world.
TickRect ticks_within(const GeoBounds& b) {
  const auto tick = [](double degrees, double origin, double (*snap)(double)) {
    return static_cast<std::int64_t>(snap(std::ldexp(degrees - origin, kTickBits)));
  };
  return {tick(b.west, -180, std::ceil), tick(b.south, -90, std::ceil), tick(b.east, -180, std::floor),
          tick(b.north, -90, std::floor)};
}

class RasterDemExport {
 public:
  RasterDemExport(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack),
        options_(options),
        progress_(progress),
        accuracy_(accuracy_of(pack)),
        patches_(pack, accuracy_.finest_error_m) {
    // Pixels lie between the pack's samples, so that its own steps would only be coarser.
    if (pack.header().quantum_m < encoding_.blue_m) encoding_ = DemEncoding::custom(pack.header().quantum_m);
  }

  Result<ExportReport> run();

 private:
  bool has(const MercatorTile& tile) const;
  int level_of(int zoom) const {
    return dem_level(pack_.header().tile_size, zoom, patches_.coarsest(), patches_.finest());
  }
  bool is_custom() const { return std::strcmp(encoding_.name, "custom") == 0; }
  std::string identity(VerticalDatum datum, const PmtilesPlan& plan) const;
  std::string metadata(VerticalDatum datum, const std::vector<ExportLevel>& levels) const;
  Result<std::vector<PmtilesTile>> make(const RasterDemSource& source,
                                        std::span<const MercatorTile> tiles) const;
  Status check(const std::vector<ExportLevel>& levels) const;
  std::string note() const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  PackPatches patches_;
  DemEncoding encoding_;
};

bool RasterDemExport::has(const MercatorTile& tile) const {
  const TickRect rect = ticks_within(mercator_bounds(tile));
  if (rect.width() <= 0 || rect.height() <= 0) return false;
  // A pack's heights go on to the ends of its tiles, beyond its data.
  const std::optional<GeoBounds>& within = options_.region ? options_.region : accuracy_.bounds;
  if (!within) return patches_.has_tile(rect, level_of(tile.zoom));
  for (const double turn : kTurns) {
    const TickRect both = intersection(
        rect, ticks_within({within->west + turn, within->south, within->east + turn, within->north}));
    if (both.width() > 0 && both.height() > 0 && patches_.has_tile(both, level_of(tile.zoom))) return true;
  }
  return false;
}

std::string RasterDemExport::identity(VerticalDatum datum, const PmtilesPlan& plan) const {
  Json json = {{"format", "pmtiles"},
               {"pack", identity_of(pack_)},
               {"datum", to_string(datum)},
               {"ellipsoidal", options_.heights == ExportHeights::ellipsoidal},
               {"geoid", options_.geoid.string()},
               {"zooms", {plan.min_zoom, plan.max_zoom}}};
  if (options_.region)
    json["region"] = {options_.region->west, options_.region->south, options_.region->east,
                      options_.region->north};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<std::vector<PmtilesTile>> RasterDemExport::make(const RasterDemSource& source,
                                                       std::span<const MercatorTile> tiles) const {
  std::vector<PmtilesTile> out;
  PackSampler sampler(pack_, kSamplerTiles);
  for (const MercatorTile& tile : tiles) {
    const int level = level_of(tile.zoom);
    const auto made = make_raster_dem(source, sampler, tile, level, level + kMeasuredLevels);
    if (!made) return made.error();
    auto png = encode_raster_dem(*made);
    if (!png) return png.error();
    out.push_back({std::move(*png), made->max_error_m});
  }
  return out;
}

std::string RasterDemExport::metadata(VerticalDatum datum, const std::vector<ExportLevel>& levels) const {
  Json metadata = {{"name", pack_.path().stem().string()},
                   {"type", "baselayer"},
                   {"format", "png"},
                   {"encoding", encoding_.name},
                   {"tile_size", kDemTilePixels},
                   {"vertical_datum", to_string(datum)},
                   {"void_height_m", 0},
                   {"generator", fmt::format("cairn {}", CAIRN_VERSION)},
                   {"levels", Json::array()}};
  if (is_custom()) {
    metadata["redFactor"] = encoding_.red_m;
    metadata["greenFactor"] = encoding_.green_m;
    metadata["blueFactor"] = encoding_.blue_m;
    metadata["baseShift"] = encoding_.base_m;
  }
  for (const ExportLevel& level : levels)
    metadata["levels"].push_back({{"zoom", level.level},
                                  {"tiles", level.tiles},
                                  {"max_error_m", level.max_error_m},
                                  {"worst", level.worst}});
  return metadata.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Status RasterDemExport::check(const std::vector<ExportLevel>& levels) const {
  const ExportLevel& finest = levels.back();
  if (!options_.max_error_m || finest.max_error_m <= *options_.max_error_m) return {};
  return failed(fmt::format("zoom {}: expected at most {:g} m off the source posts, found {:g} m in tile {}",
                            finest.level, *options_.max_error_m, finest.max_error_m, finest.worst));
}

std::string RasterDemExport::note() const {
  return fmt::format(
      "MapLibre source: \"type\": \"raster-dem\", \"tileSize\": {}, \"encoding\": \"{}\"{}. The largest "
      "error is that of its "
      "bilinear reading. Pixels without height have that of the rim of the ground beside them, or 0 m.",
      kDemTilePixels, encoding_.name,
      is_custom()
          ? fmt::format(", \"redFactor\": {}, \"greenFactor\": {}, \"blueFactor\": {}, \"baseShift\": {}",
                        encoding_.red_m, encoding_.green_m, encoding_.blue_m, encoding_.base_m)
          : "");
}

Result<ExportReport> RasterDemExport::run() {
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::as_stored), options_.geoid);
  if (!shift) return shift.error();
  const std::size_t tile_bytes =
      static_cast<std::size_t>(pack_.header().tile_size) * pack_.header().tile_size * sizeof(float);
  const std::size_t fixed = kProgramBytes + static_cast<std::size_t>(options_.threads) * kThreadBytes;
  const std::size_t spare = options_.memory_bytes > fixed ? options_.memory_bytes - fixed : 0;
  MetreTiles tiles(pack_, std::clamp<std::size_t>(spare / tile_bytes, 4, 256));
  const RasterDemSource source{patches_, tiles, *shift, encoding_,
                               [this](const MercatorTile& tile) { return has(tile); }};
  PmtilesPlan plan;
  plan.max_zoom = finest_dem_zoom(pack_.header().tile_size, patches_.finest());
  if (auto status = choose_zooms(options_, plan); !status) return status.error();
  plan.bounds = bounds_of_archive(options_.region ? *options_.region
                                                  : accuracy_.bounds.value_or(GeoBounds{-180, -90, 180, 90}));
  plan.identity = identity(*datum, plan);
  plan.has = source.has;
  plan.make = [&](std::span<const MercatorTile> some) { return make(source, some); };
  plan.metadata = [&](const std::vector<ExportLevel>& levels) { return metadata(shift->datum, levels); };
  plan.check = [this](const std::vector<ExportLevel>& levels) { return check(levels); };
  auto levels = write_pmtiles(plan, options_, progress_);
  if (!levels) return levels.error();
  ExportReport report;
  report.levels = std::move(*levels);
  report.datum = shift->datum;
  report.notes.push_back(note());
  return report;
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  if (!pack.levels(Layer::heights))
    return bad_data(pack.path().string() + ": expected height tiles, found none");
  return RasterDemExport(pack, options, progress).run();
}

}  // namespace

extern const ExportFormat pmtiles_exporter;
const ExportFormat pmtiles_exporter{
    "pmtiles", "one file of MapLibre raster-dem tiles, as Terrarium or in the pack's own steps", write};

}  // namespace cairn
