#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/export_target.h"
#include "builder/app/one_of.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/export/height_image.h"
#include "builder/export/texture_file.h"
#include "cairn/pack_reader.h"

namespace cairn {
namespace {

struct ExtractOptions {
  std::string pack;
  std::string tile;
  std::string output;
  Layer layer = Layer::heights;
  bool json = false;
};

using HeightWriter = Status (*)(const std::filesystem::path&, const HeightImage&);
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

Status extract(const PackReader& pack, const TileId& id, const ExtractOptions& options) {
  const auto entry = pack.find(options.layer, id);
  if (!entry) {
    return failed(pack.path().string() + ": " + to_string(options.layer) + " " + to_string(id) +
                  ": expected a tile, the pack has none");
  }
  const std::string extension = extension_of(options.output);
  if (options.layer == Layer::imagery) {
    const Result<TextureTile> tile = read_texture_tile(pack, *entry);
    return tile ? texture_writer_for(extension)(options.output, *tile) : Status(tile.error());
  }
  const Result<HeightTile> tile = pack.read_height_tile(*entry);
  if (!tile) return tile.error();
  return height_writer_for(extension)(options.output, image_of(*tile, id, pack.header()));
}

int run_extract(const ExtractOptions& options) {
  const bool imagery = options.layer == Layer::imagery;
  const std::string extension = extension_of(options.output);
  if (imagery ? texture_writer_for(extension) == nullptr : height_writer_for(extension) == nullptr) {
    return report_error(usage_error(options.output + ": expected a name that ends in " +
                                    (imagery ? ".dds or .png" : ".tif, .png or .hgt")));
  }
  const std::optional<TileId> id = parse_tile(options.tile);
  if (!id) return report_error(usage_error("tile: expected L/X/Y of the grid, found " + options.tile));
  const Result<PackReader> pack = PackReader::open(options.pack);
  if (!pack) return report_error(pack.error());
  if (const Status status = check_export_target(options.output, *pack); !status)
    return report_error(status.error());
  if (const Status status = extract(*pack, *id, options); !status) return report_error(status.error());
  const int side = pack->header().tile_size - (imagery ? 1 : 0);
  const GeoBounds b = tile_bounds(*id);
  if (options.json) {
    const nlohmann::ordered_json report = {
        {"output", options.output},
        {"tile", to_string(*id)},
        {"layer", to_string(options.layer)},
        {"samples", side},
        {"bounds", {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}}}};
    fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}: {}x{} {} of tile {}, west {} south {} east {} north {}\n", options.output, side, side,
               to_string(options.layer), to_string(*id), b.west, b.south, b.east, b.north);
  }
  return 0;
}

}  // namespace

void add_extract(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ExtractOptions>();
  CLI::App* verb = app.add_subcommand("extract", "Write one tile as a file that other programs read");
  verb->add_option("PACK", options->pack, "The pack")->required();
  verb->add_option("TILE", options->tile, "L/X/Y")->required();
  verb->add_option(
          "-o,--output", options->output,
          "TILE.tif (GeoTIFF), TILE.png (16 bits, metres + 32768, void 0) or TILE.hgt (int16 metres, "
          "void -32768); of imagery TILE.dds (as it is stored, with mips) or TILE.png; replaced where it "
          "exists")
      ->required();
  const std::map<std::string, Layer> layers{{"heights", Layer::heights}, {"imagery", Layer::imagery}};
  verb->add_option("--layer", options->layer, "heights or imagery")
      ->transform(one_of(layers))
      ->default_str("heights");
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_extract(*options); });
}

}  // namespace cairn
