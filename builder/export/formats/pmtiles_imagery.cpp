// A pack's imagery as WebP tiles in one PMTiles archive.
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/pack_accuracy.h"
#include "builder/export/pmtiles_export.h"
#include "builder/export/raster_dem_tile.h"
#include "builder/export/webp_picture.h"
#include "format/imagery_sampler.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kPixels = kDemTilePixels;
constexpr int kParts = 2;  // texels along a side of a pixel, of which it is the mean

/// The rectangles of the pack's images, by its metadata; of all that was baked where it does not say.
std::vector<GeoBounds> image_bounds(const PackReader& pack) {
  std::vector<GeoBounds> out;
  const Json metadata = Json::parse(pack.metadata_json(), nullptr, false);
  const Json::json_pointer place("/imagery/sources");
  if (metadata.is_object() && metadata.contains(place) && metadata.at(place).is_array()) {
    for (const Json& source : metadata.at(place)) {
      const Json bounds = source.is_object() ? source.value("bounds", Json()) : Json();
      if (!bounds.is_object()) return {{-180, -90, 180, 90}};
      out.push_back({bounds.value("west", -180.0), bounds.value("south", -90.0), bounds.value("east", 180.0),
                     bounds.value("north", 90.0)});
    }
  }
  return out.empty() ? std::vector<GeoBounds>{{-180, -90, 180, 90}} : out;
}

bool overlap(const GeoBounds& a, const GeoBounds& b) {
  return a.west < b.east && b.west < a.east && a.south < b.north && b.south < a.north;
}

class ImageryExport {
 public:
  ImageryExport(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack),
        options_(options),
        progress_(progress),
        levels_(*pack.levels(Layer::imagery)),
        images_(image_bounds(pack)) {}

  Result<ExportReport> run();

 private:
  bool has(const MercatorTile& tile) const;
  GeoBounds bounds() const;
  std::vector<std::uint8_t> draw(ImagerySampler& texels, const MercatorTile& tile, Status& status) const;
  Result<std::vector<PmtilesTile>> make(std::span<const MercatorTile> tiles) const;
  std::string identity(const PmtilesPlan& plan) const;
  std::string metadata(const std::vector<ExportLevel>& levels) const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackReader::LevelRange levels_;
  std::vector<GeoBounds> images_;
};

bool ImageryExport::has(const MercatorTile& tile) const {
  const GeoBounds own = mercator_bounds(tile);
  for (const double turn : kTurns) {
    const GeoBounds turned{own.west + turn, own.south, own.east + turn, own.north};
    if (options_.region && !overlap(turned, *options_.region)) continue;
    for (const double other : kTurns) {
      const GeoBounds again{turned.west + other, own.south, turned.east + other, own.north};
      if (std::any_of(images_.begin(), images_.end(), [&](const GeoBounds& b) { return overlap(again, b); }))
        return true;
    }
  }
  return false;
}

GeoBounds ImageryExport::bounds() const {
  if (options_.region) return *options_.region;
  GeoBounds all = images_.front();
  for (const GeoBounds& b : images_)
    all = {std::min(all.west, b.west), std::min(all.south, b.south), std::max(all.east, b.east),
           std::max(all.north, b.north)};
  return all;
}

/// The tile's pixels, each the mean of the texels in its middle and weighted by their alpha; empty where none
/// has a colour.
std::vector<std::uint8_t> ImageryExport::draw(ImagerySampler& texels, const MercatorTile& tile,
                                              Status& status) const {
  const int level =
      dem_level(pack_.header().tile_size, tile.zoom + kParts / 2, levels_.coarsest, levels_.finest);
  std::vector<std::uint8_t> rgba;
  rgba.reserve(std::size_t{kPixels} * kPixels * 4);
  bool any = false;
  for (int r = 0; r < kPixels; ++r) {
    for (int c = 0; c < kPixels; ++c) {
      std::array<unsigned, 4> sum{};
      for (int part = 0; part < kParts * kParts; ++part) {
        const LonLat place = mercator_place(tile, (c + (part % kParts + 0.5) / kParts) / kPixels,
                                            (r + (part / kParts + 0.5) / kParts) / kPixels);
        const auto colour = texels.colour_at(place, level);
        if (!colour) {
          status = colour.error();
          return {};
        }
        const unsigned alpha = (*colour)[3];
        for (std::size_t k = 0; k < 3; ++k) sum[k] += (*colour)[k] * alpha;
        sum[3] += alpha;
      }
      for (std::size_t k = 0; k < 3; ++k)
        rgba.push_back(static_cast<std::uint8_t>(sum[3] == 0 ? 0 : (sum[k] + sum[3] / 2) / sum[3]));
      rgba.push_back(static_cast<std::uint8_t>((sum[3] + kParts * kParts / 2) / (kParts * kParts)));
      any = any || rgba.back() != 0;
    }
  }
  return any ? rgba : std::vector<std::uint8_t>();
}

Result<std::vector<PmtilesTile>> ImageryExport::make(std::span<const MercatorTile> tiles) const {
  std::vector<PmtilesTile> out;
  ImagerySampler texels(pack_);
  for (const MercatorTile& tile : tiles) {
    Status status;
    const std::vector<std::uint8_t> rgba = draw(texels, tile, status);
    if (!status) return status.error();
    if (rgba.empty()) {
      out.emplace_back();
      continue;
    }
    auto picture = encode_webp(rgba, kPixels);
    if (!picture) return picture.error();
    out.push_back({std::move(picture->bytes), picture->colour_rms});
  }
  return out;
}

std::string ImageryExport::identity(const PmtilesPlan& plan) const {
  Json json = {
      {"format", "pmtiles-imagery"}, {"pack", identity_of(pack_)}, {"zooms", {plan.min_zoom, plan.max_zoom}}};
  if (options_.region)
    json["region"] = {options_.region->west, options_.region->south, options_.region->east,
                      options_.region->north};
  return json.dump();
}

std::string ImageryExport::metadata(const std::vector<ExportLevel>& levels) const {
  Json metadata = {{"name", pack_.path().stem().string()},
                   {"type", "baselayer"},
                   {"format", "webp"},
                   {"tile_size", kPixels},
                   {"generator", fmt::format("cairn {}", CAIRN_VERSION)},
                   {"levels", Json::array()}};
  for (const ExportLevel& level : levels)
    metadata["levels"].push_back({{"zoom", level.level},
                                  {"tiles", level.tiles},
                                  {"colour_rms", level.max_error_m},
                                  {"worst", level.worst}});
  return metadata.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<ExportReport> ImageryExport::run() {
  if (options_.max_error_m || options_.heights || options_.datum || !options_.geoid.empty())
    return usage_error(
        "imagery: expected no error, datum, heights or geoid, since it has no heights, found one");
  PmtilesPlan plan;
  plan.type = PmtilesInfo::TileType::webp;
  plan.max_zoom = finest_dem_zoom(pack_.header().tile_size, levels_.finest);
  if (auto status = choose_zooms(options_, plan); !status) return status.error();
  plan.bounds = bounds_of_archive(bounds());
  plan.identity = identity(plan);
  plan.has = [this](const MercatorTile& tile) { return has(tile); };
  plan.make = [this](std::span<const MercatorTile> tiles) { return make(tiles); };
  plan.metadata = [this](const std::vector<ExportLevel>& levels) { return metadata(levels); };
  plan.check = [](const std::vector<ExportLevel>&) { return Status(); };
  auto levels = write_pmtiles(plan, options_, progress_);
  if (!levels) return levels.error();
  ExportReport report;
  report.is_imagery = true;
  for (ExportLevel& level : *levels) level.colour_rms = std::exchange(level.max_error_m, 0);
  report.levels = std::move(*levels);
  report.notes.push_back(fmt::format(
      "MapLibre source: \"type\": \"raster\", \"tileSize\": {}. What compression changed is the root mean "
      "square of a tile's colours, of 255.",
      kPixels));
  return report;
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  if (!pack.levels(Layer::imagery)) return bad_data(pack.path().string() + ": expected imagery, found none");
  return ImageryExport(pack, options, progress).run();
}

}  // namespace

extern const ExportFormat pmtiles_imagery_exporter;
const ExportFormat pmtiles_imagery_exporter{"pmtiles-imagery",
                                            "one file of the imagery as WebP tiles, for MapLibre", write};

}  // namespace cairn
