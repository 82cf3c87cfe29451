// MapLibre raster-dem tiles in one PMTiles archive.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/bake/pipeline.h"
#include "builder/export/export_folder.h"
#include "builder/export/export_format.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/pmtiles_writer.h"
#include "builder/export/raster_dem_tile.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kBatchTiles = 16;
constexpr std::size_t kSamplerTiles = 12;  // of a thread
constexpr std::size_t kProgramBytes = std::size_t{48} << 20;
constexpr std::size_t kThreadBytes = std::size_t{36} << 20;
constexpr int kMostZoom = 22;
constexpr const char* kWhole = "whole";  // the archive's name before it has its own
/// Tiles are measured at the samples of so many levels below their own, and those tiles' errors are added.
constexpr int kMeasuredLevels = 3;

struct Batch {
  std::vector<std::byte> bytes;  // of all its tiles
  std::vector<std::size_t> ends;
  std::vector<ExportLevel> parts;  // one a tile
};

std::string name_of(const MercatorTile& tile) {
  return fmt::format("{}/{}/{}", tile.zoom, tile.x, tile.y);
}

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
        patches_(pack, accuracy_.finest_error_m) {}

  Result<ExportReport> run();

 private:
  Status plan();
  void list(const MercatorTile& tile);
  bool has(const MercatorTile& tile) const;
  int level_of(int zoom) const;
  GeoBounds bounds() const;
  std::string identity(VerticalDatum datum) const;
  Result<Batch> make(const RasterDemSource& source, std::size_t i) const;
  Status take(ExportFolder& folder, std::size_t i, Batch&& batch);
  Status replay(const std::string& line);
  Status write_archive(const ExportFolder& folder, const ExportReport& report) const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  PackPatches patches_;
  DemEncoding encoding_;
  int min_zoom_ = 0;
  int max_zoom_ = 0;
  std::vector<MercatorTile> tiles_;             // in the archive's order
  std::vector<std::vector<std::size_t>> ends_;  // of the finished batches' tiles
  std::map<int, ExportLevel> levels_;
  Progress now_;
};

int RasterDemExport::level_of(int zoom) const {
  return dem_level(pack_.header().tile_size, zoom, patches_.coarsest(), patches_.finest());
}

GeoBounds RasterDemExport::bounds() const {
  GeoBounds b = options_.region ? *options_.region : accuracy_.bounds.value_or(GeoBounds{-180, -90, 180, 90});
  if (b.east > 180) b.west = -180, b.east = 180;  // the archive knows no bounds across the antimeridian
  return {std::max(b.west, -180.0), std::max(b.south, -kMercatorLimit), b.east,
          std::min(b.north, kMercatorLimit)};
}

bool RasterDemExport::has(const MercatorTile& tile) const {
  const TickRect rect = ticks_within(mercator_bounds(tile));
  if (rect.width() <= 0 || rect.height() <= 0) return false;
  // A pack's heights go on to the ends of its tiles, beyond its data.
  const std::optional<GeoBounds>& within = options_.region ? options_.region : accuracy_.bounds;
  if (!within) return patches_.has_tile(rect, level_of(tile.zoom));
  for (const double turn : {-360.0, 0.0, 360.0}) {
    const TickRect bounds =
        ticks_within({within->west + turn, within->south, within->east + turn, within->north});
    const TickRect both{std::max(rect.west, bounds.west), std::max(rect.south, bounds.south),
                        std::min(rect.east, bounds.east), std::min(rect.north, bounds.north)};
    if (both.width() > 0 && both.height() > 0 && patches_.has_tile(both, level_of(tile.zoom))) return true;
  }
  return false;
}

void RasterDemExport::list(const MercatorTile& tile) {
  if (!has(tile)) return;
  if (tile.zoom >= min_zoom_) tiles_.push_back(tile);
  if (tile.zoom == max_zoom_) return;
  for (int q = 0; q < 4; ++q) list({tile.zoom + 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)});
}

Status RasterDemExport::plan() {
  max_zoom_ = std::min(finest_dem_zoom(pack_.header().tile_size, patches_.finest()), kMostZoom);
  if (options_.levels) {
    min_zoom_ = options_.levels->coarsest;
    max_zoom_ = options_.levels->finest;
    if (min_zoom_ < 0 || max_zoom_ > kMostZoom)
      return usage_error(
          fmt::format("levels: expected zooms of 0 to {}, found {} to {}", kMostZoom, min_zoom_, max_zoom_));
  }
  list({0, 0, 0});
  if (tiles_.empty())
    return failed(pack_.path().string() +
                  ": expected heights between 85.05 degrees south and north in the region "
                  "and at these zooms, the pack has none");
  std::sort(tiles_.begin(), tiles_.end(),
            [](const MercatorTile& a, const MercatorTile& b) { return pmtiles_id(a) < pmtiles_id(b); });
  // Pixels lie between the pack's samples, so that its own steps would only be coarser.
  if (pack_.header().quantum_m < encoding_.blue_m) encoding_ = DemEncoding::custom(pack_.header().quantum_m);
  return {};
}

std::string RasterDemExport::identity(VerticalDatum datum) const {
  Json json = {{"format", "pmtiles"},
               {"pack", identity_of(pack_)},
               {"datum", to_string(datum)},
               {"ellipsoidal", options_.heights == ExportHeights::ellipsoidal},
               {"geoid", options_.geoid.string()},
               {"zooms", {min_zoom_, max_zoom_}}};
  if (options_.region)
    json["region"] = {options_.region->west, options_.region->south, options_.region->east,
                      options_.region->north};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::size_t batches(std::size_t tiles) {
  return (tiles + kBatchTiles - 1) / kBatchTiles;
}

void add(const ExportLevel& part, ExportLevel& sum) {
  sum.level = part.level;
  sum.tiles += part.tiles;
  sum.bytes += part.bytes;
  if (part.max_error_m <= sum.max_error_m && !sum.worst.empty()) return;
  sum.max_error_m = part.max_error_m;
  sum.worst = part.worst;
}

Result<Batch> RasterDemExport::make(const RasterDemSource& source, std::size_t i) const {
  Batch batch;
  PackSampler sampler(pack_, kSamplerTiles);
  const std::size_t end = std::min(tiles_.size(), (i + 1) * kBatchTiles);
  for (std::size_t t = i * kBatchTiles; t < end; ++t) {
    const MercatorTile& tile = tiles_[t];
    const int level = level_of(tile.zoom);
    const auto made = make_raster_dem(source, sampler, tile, level, level + kMeasuredLevels);
    if (!made) return made.error();
    const auto png = encode_raster_dem(*made);
    if (!png) return png.error();
    batch.bytes.insert(batch.bytes.end(), png->begin(), png->end());
    batch.ends.push_back(batch.bytes.size());
    // A batch may hold tiles of two zooms: each is noted by itself.
    ExportLevel one{tile.zoom, 1, png->size(), 0, 0, 0, made->max_error_m, name_of(tile)};
    batch.parts.push_back(one);
  }
  return batch;
}

Status RasterDemExport::take(ExportFolder& folder, std::size_t i, Batch&& batch) {
  if (auto status = folder.write(std::to_string(i), batch.bytes); !status) return status;
  Json line = {{"batch", i}, {"ends", batch.ends}, {"tiles", Json::array()}};
  for (const ExportLevel& part : batch.parts)
    line["tiles"].push_back({part.level, part.bytes, part.max_error_m, part.worst});
  const std::string text = line.dump();
  if (auto status = replay(text); !status) return status;
  if (auto status = folder.append(text); !status) return status;
  now_.done = i + 1;
  now_.bytes_written += batch.bytes.size();
  return progress_(now_)
             ? Status()
             : Status(failed(fmt::format("export: cancelled after {} of {} parts", i + 1, now_.total)));
}

/// Counts a finished batch.
Status RasterDemExport::replay(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("ends") || json.value("batch", SIZE_MAX) != ends_.size())
    return bad_data(options_.target.string() + ".part: journal: expected a finished part, found " + line);
  ends_.push_back(json.at("ends").get<std::vector<std::size_t>>());
  for (const Json& tile : json.at("tiles"))
    add({tile.at(0), 1, tile.at(1), 0, 0, 0, tile.at(2), tile.at(3)}, levels_[tile.at(0).get<int>()]);
  return {};
}

Status RasterDemExport::write_archive(const ExportFolder& folder, const ExportReport& report) const {
  auto archive = PmtilesWriter::create(folder.path() / kWhole);
  if (!archive) return archive.error();
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    const auto file = File::open_to_read(folder.path() / std::to_string(i));
    if (!file) return file.error();
    std::vector<std::byte> bytes(ends_[i].back());
    if (auto status = file->read(0, bytes); !status) return status;
    std::size_t from = 0;
    for (std::size_t t = 0; t < ends_[i].size(); ++t) {
      const std::size_t end = ends_[i][t];
      if (auto status = archive->add(pmtiles_id(tiles_[i * kBatchTiles + t]),
                                     std::span(bytes).subspan(from, end - from));
          !status)
        return status;
      from = end;
    }
  }
  Json metadata = {{"name", pack_.path().stem().string()},
                   {"type", "baselayer"},
                   {"format", "png"},
                   {"encoding", encoding_.name},
                   {"tile_size", kDemTilePixels},
                   {"vertical_datum", to_string(report.datum)},
                   {"void_height_m", 0},
                   {"generator", fmt::format("cairn {}", CAIRN_VERSION)},
                   {"levels", Json::array()}};
  if (std::strcmp(encoding_.name, "custom") == 0) {
    metadata["redFactor"] = encoding_.red_m;
    metadata["greenFactor"] = encoding_.green_m;
    metadata["blueFactor"] = encoding_.blue_m;
    metadata["baseShift"] = encoding_.base_m;
  }
  for (const ExportLevel& level : report.levels)
    metadata["levels"].push_back({{"zoom", level.level},
                                  {"tiles", level.tiles},
                                  {"max_error_m", level.max_error_m},
                                  {"worst", level.worst}});
  PmtilesInfo info;
  info.min_zoom = tiles_.front().zoom;
  info.max_zoom = tiles_.back().zoom;
  info.bounds = bounds();
  info.metadata = metadata.dump(-1, ' ', false, Json::error_handler_t::replace);
  return archive->finish(info);
}

Result<ExportReport> RasterDemExport::run() {
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::as_stored), options_.geoid);
  if (!shift) return shift.error();
  if (auto status = plan(); !status) return status.error();
  auto folder = ExportFolder::begin(options_.target, identity(*datum), options_.resume);
  if (!folder) return folder.error();
  now_ = {"export", 0, batches(tiles_.size()), 0};
  for (const std::string& line : folder->done())
    if (auto status = replay(line); !status) return status.error();
  const std::size_t tile_bytes =
      static_cast<std::size_t>(pack_.header().tile_size) * pack_.header().tile_size * sizeof(float);
  const std::size_t fixed = kProgramBytes + static_cast<std::size_t>(options_.threads) * kThreadBytes;
  const std::size_t spare = options_.memory_bytes > fixed ? options_.memory_bytes - fixed : 0;
  MetreTiles tiles(pack_, std::clamp<std::size_t>(spare / tile_bytes, 4, 256));
  const RasterDemSource source{patches_, tiles, *shift, encoding_,
                               [this](const MercatorTile& tile) { return has(tile); }};
  tbb::task_arena arena(options_.threads);
  const Status made = arena.execute([&] {
    return run_in_order<Batch>(
        folder->done().size(), batches(tiles_.size()), static_cast<std::size_t>(options_.threads) + 1,
        [&](std::size_t i) { return make(source, i); },
        [&](std::size_t i, Batch&& batch) { return take(*folder, i, std::move(batch)); });
  });
  if (!made) return made.error();
  ExportReport report;
  report.datum = shift->datum;
  for (const auto& [zoom, level] : levels_) report.levels.push_back(level);
  const ExportLevel& finest = report.levels.back();
  if (options_.max_error_m && finest.max_error_m > *options_.max_error_m)
    return failed(
        fmt::format("zoom {}: expected at most {:g} m off the source posts, found {:g} m in tile {}",
                    finest.level, *options_.max_error_m, finest.max_error_m, finest.worst));
  if (auto status = write_archive(*folder, report); !status) return status.error();
  if (auto status = folder->finish_as_file(kWhole); !status) return status.error();
  report.notes.push_back(fmt::format(
      "MapLibre source: \"type\": \"raster-dem\", \"tileSize\": {}, \"encoding\": \"{}\"{}. The largest "
      "error is that of its "
      "bilinear reading. Pixels without height are the mean of those around them, or 0 m.",
      kDemTilePixels, encoding_.name,
      std::strcmp(encoding_.name, "custom") != 0
          ? ""
          : fmt::format(", \"redFactor\": {}, \"greenFactor\": {}, \"blueFactor\": {}, \"baseShift\": {}",
                        encoding_.red_m, encoding_.green_m, encoding_.blue_m, encoding_.base_m)));
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
