#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/height_image.h"
#include "format/pack_reader.h"

namespace cairn {
namespace {

struct ExtractOptions {
  std::string pack;
  std::string tile;
  std::string output;
  bool json = false;
};

using Writer = Status (*)(const std::filesystem::path&, const HeightImage&);

Writer writer_for(const std::filesystem::path& output) {
  std::string extension = output.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".tif" || extension == ".tiff") return write_height_tiff;
  if (extension == ".png") return write_height_png;
  if (extension == ".hgt") return write_height_hgt;
  return nullptr;
}

std::optional<TileId> parse_tile(const std::string& text) {
  TileId id;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d/%d/%d%c", &id.level, &id.x, &id.y, &rest) != 3) return std::nullopt;
  return is_valid(id) ? std::optional(id) : std::nullopt;
}

Status extract(const PackReader& pack, const TileId& id, const std::string& output, Writer write) {
  const auto entry = pack.find(Layer::heights, id);
  if (!entry) {
    return failed(pack.path().string() + ": heights " + to_string(id) +
                  ": expected a tile, the pack has none");
  }
  const Result<HeightTile> tile = pack.read_height_tile(*entry);
  if (!tile) return tile.error();
  return write(output, image_of(*tile, id, pack.header()));
}

int run_extract(const ExtractOptions& options) {
  const Writer write = writer_for(options.output);
  if (write == nullptr) {
    return report_error(usage_error(options.output + ": expected a name that ends in .tif, .png or .hgt"));
  }
  const std::optional<TileId> id = parse_tile(options.tile);
  if (!id) return report_error(usage_error("tile: expected L/X/Y of the grid, found " + options.tile));
  const Result<PackReader> pack = PackReader::open(options.pack);
  if (!pack) return report_error(pack.error());
  if (const Status status = extract(*pack, *id, options.output, write); !status)
    return report_error(status.error());
  const GeoBounds b = tile_bounds(*id);
  if (options.json) {
    const nlohmann::ordered_json report = {
        {"output", options.output},
        {"tile", to_string(*id)},
        {"samples", pack->header().tile_size},
        {"bounds", {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}}}};
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print("{}: {}x{} heights of tile {}, west {} south {} east {} north {}\n", options.output,
               pack->header().tile_size, pack->header().tile_size, to_string(*id), b.west, b.south, b.east,
               b.north);
  }
  return 0;
}

}  // namespace

void add_extract(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ExtractOptions>();
  CLI::App* verb =
      app.add_subcommand("extract", "Write one tile's heights as a file that other programs read");
  verb->add_option("PACK", options->pack, "The pack")->required();
  verb->add_option("TILE", options->tile, "L/X/Y")->required();
  verb->add_option(
          "-o,--output", options->output,
          "TILE.tif (GeoTIFF), TILE.png (16 bits, metres + 32768, void 0) or TILE.hgt (int16 metres, "
          "void -32768); replaced where it exists")
      ->required();
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_extract(*options); });
}

}  // namespace cairn
