#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_progress.h"
#include "builder/app/export_target.h"
#include "builder/app/extract_objects.h"
#include "builder/app/extract_region.h"
#include "builder/app/one_of.h"
#include "builder/app/region_argument.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/export/height_image.h"
#include "builder/export/texture_file.h"
#include "cairn/pack_reader.h"
#include "cairn/remote_pack.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct ExtractOptions {
  std::string pack;
  std::string tile;
  std::string output;
  std::vector<double> region;
  std::optional<int> level;
  std::optional<double> spacing;
  Layer layer = Layer::heights;
  bool json = false;
};

using HeightWriter = Status (*)(const std::filesystem::path&, const HeightGrid&, const HeightRows&);
using TextureWriter = Status (*)(const std::filesystem::path&, const TextureTile&);

std::string extension_of(const std::filesystem::path& output) {
  std::string extension = output.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

HeightWriter height_writer_for(const std::string& extension) {
  if (extension == ".tif" || extension == ".tiff") return write_height_tiff;
  if (extension == ".png") return write_height_png;
  if (extension == ".hgt") return write_height_hgt;
  return nullptr;
}

TextureWriter texture_writer_for(const std::string& extension) {
  if (extension == ".dds") return write_texture_dds;
  if (extension == ".png") return write_texture_png;
  return nullptr;
}

std::optional<TileId> parse_tile(const std::string& text) {
  TileId id;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d/%d/%d%c", &id.level, &id.x, &id.y, &rest) != 3) return std::nullopt;
  return is_valid(id) ? std::optional(id) : std::nullopt;
}

std::string cell_name(const GeoBounds& cell) {
  const int lat = static_cast<int>(std::lround(cell.south));
  const int lon =
      static_cast<int>(std::lround(cell.west + 180 - 360 * std::floor((cell.west + 180) / 360))) - 180;
  return fmt::format("{}{:02}{}{:03}.hgt", lat < 0 ? 'S' : 'N', std::abs(lat), lon < 0 ? 'W' : 'E',
                     std::abs(lon));
}

/// Other programs know the place of a .hgt by its name only.
Status check_cell_name(const std::string& output, const GeoBounds& cell) {
  std::string name = std::filesystem::path(output).filename().string();
  const std::string expected = cell_name(cell);
  const bool same =
      std::equal(name.begin(), name.end(), expected.begin(), expected.end(), [](char a, char b) {
        return std::toupper(static_cast<unsigned char>(a)) == std::toupper(static_cast<unsigned char>(b));
      });
  if (same) return {};
  return usage_error(fmt::format("{}: expected the name {}, by which other programs know the cell's place",
                                 output, expected));
}

Status check_words_of_objects(const ExtractOptions& options, const std::string& extension) {
  if (extension != ".csv") return usage_error(options.output + ": expected a name that ends in .csv");
  if (!options.tile.empty() || options.level || options.spacing)
    return usage_error(
        "extract: expected all objects or those of --region, found a tile, a level or a spacing");
  return {};
}

/// Wrong usage that shows without the pack.
Status check_words(const ExtractOptions& options) {
  const bool imagery = options.layer == Layer::imagery;
  const std::string extension = extension_of(options.output);
  if (options.layer == Layer::objects) return check_words_of_objects(options, extension);
  if (imagery ? texture_writer_for(extension) == nullptr : height_writer_for(extension) == nullptr)
    return usage_error(options.output + ": expected a name that ends in " +
                       (imagery ? ".dds or .png" : ".tif, .png or .hgt"));
  if (options.tile.empty() == options.region.empty())
    return usage_error("extract: expected a tile L/X/Y or --region, and not both");
  if (!options.tile.empty() && !parse_tile(options.tile))
    return usage_error("tile: expected L/X/Y of the grid, found " + options.tile);
  if (imagery && !options.region.empty())
    return usage_error("--region: expected heights, found imagery, of which single tiles can be extracted");
  if (options.region.empty() && (options.level || options.spacing))
    return usage_error("--level, --spacing: expected --region with them, found a tile, which has its own");
  if (options.level && options.spacing)
    return usage_error("--level, --spacing: expected one of them, found both");
  if (extension == ".hgt" && (options.level || options.spacing))
    return usage_error("--level, --spacing: expected none with .hgt, which has 1201 or 3601 posts");
  return {};
}

void print_report(const ExtractOptions& options, const Json& place, int columns, int rows,
                  const GeoBounds& b) {
  if (options.json) {
    Json report = {{"output", options.output}};
    report.update(place);
    report["layer"] = to_string(options.layer);
    report["columns"] = columns;
    report["rows"] = rows;
    if (columns == rows) report["samples"] = columns;
    report["bounds"] = {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}};
    fmt::print("{}\n", report.dump(2, ' ', false, Json::error_handler_t::replace));
    return;
  }
  const std::string what = place.contains("tile") ? "tile " + place["tile"].get<std::string>()
                                                  : fmt::format("level {}", place["level"].get<int>());
  fmt::print("{}: {}x{} {} of {}, west {} south {} east {} north {}\n", options.output, columns, rows,
             to_string(options.layer), what, b.west, b.south, b.east, b.north);
}

Status extract_tile(const PackReader& pack, const TileId& id, const ExtractOptions& options) {
  const auto entry = pack.find(options.layer, id);
  if (!entry) {
    return failed(pack.path().string() + ": " + to_string(options.layer) + " " + to_string(id) +
                  ": expected a tile, the pack has none" +
                  (options.layer == Layer::heights ? "; --region draws it from coarser ones" : ""));
  }
  const std::string extension = extension_of(options.output);
  Status status;
  if (options.layer == Layer::imagery) {
    const Result<TextureTile> tile = read_texture_tile(pack, *entry);
    status = tile ? texture_writer_for(extension)(options.output, *tile) : Status(tile.error());
  } else {
    const Result<HeightTile> tile = pack.read_height_tile(*entry);
    status = tile ? height_writer_for(extension)(options.output, grid_of(*tile, id, pack.header()),
                                                 rows_of(*tile, pack.header()))
                  : Status(tile.error());
  }
  if (!status) return status;
  const int side = pack.header().tile_size - (options.layer == Layer::imagery ? 1 : 0);
  print_report(options, {{"tile", to_string(id)}}, side, side, tile_bounds(id));
  return {};
}

Result<RegionPlan> plan_of(const PackReader& pack, const GeoBounds& region, const ExtractOptions& options) {
  if (extension_of(options.output) == ".hgt") {
    auto plan = plan_cell(pack, region);
    if (!plan) return plan;
    if (auto named = check_cell_name(options.output, region); !named) return named.error();
    return plan;
  }
  return options.spacing ? plan_spacing(pack, region, *options.spacing)
                         : plan_samples(pack, region, options.level);
}

Status extract_region(const PackReader& pack, const GeoBounds& region, const ExtractOptions& options) {
  const auto plan = plan_of(pack, region, options);
  if (!plan) return plan.error();
  {
    BakeProgress progress;
    const Status status = height_writer_for(extension_of(options.output))(options.output, plan->grid,
                                                                          rows_of(pack, *plan, progress));
    if (!status) return status;
  }
  const GeoGrid& posts = plan->grid.posts;
  const GeoBounds bounds{posts.west, posts.north - (posts.rows - 1) * posts.row_degrees,
                         posts.west + (posts.columns - 1) * posts.column_degrees, posts.north};
  print_report(options, {{"level", plan->level}}, posts.columns, posts.rows, bounds);
  return {};
}

Status extract_csv(const PackReader& pack, const ExtractOptions& options) {
  std::optional<GeoBounds> bounds;
  if (!options.region.empty()) {
    const auto region = region_of(options.region);
    if (!region) return region.error();
    bounds = *region;
  }
  const auto written = extract_objects(pack, bounds, options.output);
  if (!written) return written.error();
  if (options.json) {
    const Json report{{"output", options.output}, {"layer", "objects"}, {"objects", *written}};
    fmt::print("{}\n", report.dump(2, ' ', false, Json::error_handler_t::replace));
  } else {
    fmt::print("{}: {} objects\n", options.output, *written);
  }
  return {};
}

Status extract(const ExtractOptions& options) {
  if (auto status = check_words(options); !status) return status;
  const Result<PackReader> pack = open_pack(options.pack);
  if (!pack) return pack.error();
  if (auto status = pack->read_index(); !status) return status;
  if (auto status = check_export_target(options.output, *pack); !status) return status;
  if (options.layer == Layer::objects) return extract_csv(*pack, options);
  if (options.tile.empty()) {
    const auto region = region_of(options.region);
    return region ? extract_region(*pack, *region, options) : Status(region.error());
  }
  const TileId id = *parse_tile(options.tile);
  if (extension_of(options.output) == ".hgt") return extract_region(*pack, tile_bounds(id), options);
  return extract_tile(*pack, id, options);
}

}  // namespace

void add_extract(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ExtractOptions>();
  CLI::App* verb = app.add_subcommand(
      "extract", "Write one tile, or the heights of a region, as a file that other programs read");
  verb->add_option("PACK", options->pack, "The pack, or its http:// or https:// address")->required();
  verb->add_option("TILE", options->tile, "L/X/Y");
  verb->add_option("-o,--output", options->output,
                   "FILE.tif (GeoTIFF), FILE.png (16 bits, metres + 32768, void 0) or, of a cell of 1 "
                   "degree, N36E028.hgt "
                   "(int16 metres, void -32768); of imagery TILE.dds (as it is stored, with mips) or "
                   "TILE.png; of objects FILE.csv, which bake --objects takes; replaced where it exists")
      ->required();
  verb->add_option(
          "--region", options->region,
          "WEST,SOUTH,EAST,NORTH in degrees: the heights of this region instead of a tile; where tiles "
          "were left out they are drawn from coarser ones")
      ->delimiter(',')
      ->expected(4);
  verb->add_option("--level", options->level,
                   "of a region: the level whose samples are written; the finest there is")
      ->check(CLI::Range(kMinLevel, kMaxLevel));
  verb->add_option("--spacing", options->spacing, "of a region: degrees from one post to the next")
      ->check(CLI::Range(1e-7, 90.0));
  const std::map<std::string, Layer> layers{
      {"heights", Layer::heights}, {"imagery", Layer::imagery}, {"objects", Layer::objects}};
  verb->add_option("--layer", options->layer, "heights, imagery or objects")
      ->transform(one_of(layers))
      ->default_str("heights");
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] {
    const Status status = extract(*options);
    exit_code = status ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
