#include "builder/serve/tile_requests.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "builder/export/grid_error.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/quantized_mesh_file.h"
#include "builder/export/quantized_mesh_tile.h"
#include "builder/export/raster_dem_tile.h"
#include "builder/serve/url_text.h"
#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostZoom = 22;
constexpr std::size_t kSamplerTiles = 12;
/// Tiles of every so many levels list those below them.
constexpr int kLevelsListed = 10;

/// Returns the address of the server as the client knows it; empty where its Host field is none.
std::string origin_of(const HttpRequest& request) {
  const std::string& host = request.field("host");
  const bool valid = !host.empty() && std::all_of(host.begin(), host.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':' || c == '[' || c == ']';
  });
  return valid ? "http://" + host : "";
}

HttpAnswer tile_json(const HttpRequest& request, const std::string& name, const OpenedPack& pack) {
  const GeoBounds world{-180, -kMercatorLimit, 180, kMercatorLimit};
  GeoBounds b = accuracy_of(pack.reader).bounds.value_or(world);
  if (b.east > 180) b.west = -180, b.east = 180;
  b.south = std::max(b.south, world.south);
  b.north = std::min(b.north, world.north);
  const Json json = {
      {"tilejson", "3.0.0"},
      {"tiles", {origin_of(request) + "/terrarium/" + escape_path(name) + "/{z}/{x}/{y}.png"}},
      {"encoding", "terrarium"},
      {"tileSize", kDemTilePixels},
      {"minzoom", 0},
      {"maxzoom",
       std::min(finest_dem_zoom(pack.reader.header().tile_size, pack.patches->finest()), kMostZoom)},
      {"bounds", {b.west, b.south, b.east, b.north}}};
  return json_answer(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

struct TileNumbers {
  int level = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
};

/// Returns the numbers of the text "LEVEL/X/Y" and the ending; nullopt where it is none, or the level is
/// above `most`.
std::optional<TileNumbers> numbers_of(const std::string& text, const std::string& ending, int most) {
  if (text.size() > 48 || !text.ends_with(ending)) return std::nullopt;
  const std::string numbers = text.substr(0, text.size() - ending.size());
  long long level = 0, x = 0, y = 0;
  int end = 0;
  if (numbers.find_first_not_of("0123456789/") != std::string::npos ||
      std::sscanf(numbers.c_str(), "%2lld/%10lld/%10lld%n", &level, &x, &y, &end) != 3 ||
      static_cast<std::size_t>(end) != numbers.size() || level > most)
    return std::nullopt;
  return TileNumbers{static_cast<int>(level), x, y};
}

/// Returns the tile that the text "ZOOM/X/Y.png" names; nullopt where it names none.
std::optional<MercatorTile> tile_of(const std::string& text) {
  const auto numbers = numbers_of(text, ".png", kMostZoom);
  if (!numbers) return std::nullopt;
  const std::int64_t across = std::int64_t{1} << numbers->level;
  if (numbers->x >= across || numbers->y >= across) return std::nullopt;
  return MercatorTile{numbers->level, numbers->x, numbers->y};
}

HttpAnswer layer_json(const std::string& name, const OpenedPack& pack) {
  const Json json = {{"tilejson", "2.1.0"},
                     {"name", name},
                     {"version", "1.0.0"},
                     {"format", "quantized-mesh-1.0"},
                     {"scheme", "tms"},
                     {"projection", "EPSG:4326"},
                     {"tiles", {"{z}/{x}/{y}.terrain?v=" + to_string(pack.reader.header().id)}},
                     {"extensions", {"octvertexnormals", "metadata"}},
                     {"metadataAvailability", kLevelsListed},
                     {"available", {{{{"startX", 0}, {"startY", 0}, {"endX", 1}, {"endY", 0}}}}},
                     {"minzoom", 0},
                     {"maxzoom", pack.meshes->finest()},
                     {"bounds", {-180, -90, 180, 90}},
                     {"vertical_datum", to_string(pack.shift.datum)}};
  return json_answer(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

HttpAnswer answer_terrarium(const HttpRequest& request, const std::string& pack_name, const OpenedPack& pack,
                            const std::string& rest) {
  if (!pack.patches) return error_answer(404, pack_name + ": expected height tiles, found none");
  if (rest == "tiles.json") return tile_json(request, pack_name, pack);
  const auto tile = tile_of(rest);
  if (!tile) return error_answer(404, "tile: expected ZOOM/X/Y.png, zoom at most 22, found " + rest);
  const std::vector<std::pair<std::string, std::string>> fields{
      {"ETag", pack.served.etag}, {"Cache-Control", "no-cache"}, {"Content-Type", "image/png"}};
  const int level =
      dem_level(pack.reader.header().tile_size, tile->zoom, pack.patches->coarsest(), pack.patches->finest());
  const auto has = [&pack, level](const MercatorTile& one) {
    return pack.patches->has_tile(ticks_around(mercator_bounds(one)), level);
  };
  if (!has(*tile)) return error_answer(404, "tile: expected one where the pack has heights, found " + rest);
  if (const std::string& known = request.field("if-none-match");
      !known.empty() && names_etag(known, pack.served.etag))
    return {304, fields, {}, {}};
  PackSampler sampler(pack.reader, kSamplerTiles);
  const VerticalShift as_stored;
  const RasterDemSource source{*pack.patches, pack.tiles, as_stored, DemEncoding::terrarium(), has};
  const auto made = make_raster_dem(source, sampler, *tile, level, pack.patches->coarsest());
  if (!made) return error_answer(500, made.error().message);
  const auto png = encode_raster_dem(*made);
  if (!png) return error_answer(500, png.error().message);
  return {200, fields, std::string(reinterpret_cast<const char*>(png->data()), png->size()), {}};
}

HttpAnswer answer_quantized_mesh(const HttpRequest& request, const std::string& pack_name,
                                 const OpenedPack& pack, const std::string& rest) {
  if (!pack.meshes)
    return error_answer(404, pack_name + ": expected heights that meshes are made of, found none");
  if (rest == "layer.json") return layer_json(pack_name, pack);
  const auto numbers = numbers_of(rest, ".terrain", pack.meshes->finest());
  if (!numbers || numbers->x >= std::int64_t{2} << numbers->level ||
      numbers->y >= std::int64_t{1} << numbers->level)
    return error_answer(404, "tile: expected LEVEL/X/Y.terrain, found " + rest);
  const GeographicTile tile{numbers->level, numbers->x, numbers->y};
  if (!pack.meshes->has(tile))
    return error_answer(404, "tile: expected one where the pack has heights, found " + rest);
  const std::vector<std::pair<std::string, std::string>> fields{
      {"ETag", pack.served.etag},
      {"Cache-Control", "no-cache"},
      {"Content-Type", "application/vnd.quantized-mesh"}};
  if (const std::string& known = request.field("if-none-match");
      !known.empty() && names_etag(known, pack.served.etag))
    return {304, fields, {}, {}};
  auto mesh = make_quantized_mesh({*pack.meshes, *pack.patches, pack.tiles, pack.shift}, tile);
  if (!mesh) return error_answer(500, mesh.error().message);
  if (tile.level % kLevelsListed == 0) mesh->available = pack.meshes->below(tile, kLevelsListed);
  const std::vector<std::byte> bytes = encode_quantized_mesh(*mesh);
  return {200, fields, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), {}};
}

}  // namespace cairn
