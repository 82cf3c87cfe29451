#include "tests/support/gl_packs.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "builder/texture_encode/texture_encode.h"
#include "cairn/build.h"
#include "format/codec.h"
#include "format/height_block.h"
#include "format/pack_writer.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr int kTileSize = 257;
constexpr double kRows = 180.0 * (1 << kRidgesFinest) * (kTileSize - 1);

const TestSurface& ridge_surface() {
  static const TestSurface surface{kTileSize, kRidgesFinest, ridges, {}};
  return surface;
}

/// A bound on what straight lines between every 2nd, 4th … sample miss of the ridges, the narrowest of which
/// are 44 samples from crest to crest and 300 m high.
void set_ridge_error(IndexEntry& entry) {
  const double error_m = std::min(std::ldexp(8.0, 2 * (kRidgesFinest - 1 - entry.id.level)), 1450.0);
  entry.geometric_error_m = entry.id.level < kRidgesFinest ? static_cast<float>(error_m) : 0;
}

std::vector<std::uint8_t> image_of(const TileId& id, int size, const ColourAt& colour) {
  const GeoBounds b = tile_bounds(id);
  std::vector<std::uint8_t> rgba;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const auto [r, g, blue] =
          colour({b.west + (column + 0.5) / size * b.width(), b.north - (row + 0.5) / size * b.height()});
      rgba.insert(rgba.end(), {r, g, blue, 255});
    }
  }
  return rgba;
}

TextureTile texture_of(const TileId& id, TextureFormat format, const ColourAt& colour) {
  TextureTile tile{format, kTileSize - 1, {}};
  for (int size = tile.size; size >= 1; size /= 2) {
    encode_texture(format, TextureQuality::normal, image_of(id, size, colour), size, size, tile.texels);
  }
  return tile;
}

std::vector<std::filesystem::path> below(const std::filesystem::path& folder,
                                         const std::vector<std::string>& names) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& name : names) paths.push_back(folder / name);
  return paths;
}

}  // namespace

std::int32_t ridges(std::int64_t column, std::int64_t row) {
  const double x = static_cast<double>(column), y = static_cast<double>(row);
  const double narrow = std::sin(3.14159265358979 * y / kRows);
  return static_cast<std::int32_t>(
      std::lround(4000 + 800 * std::cos(y / 23) +
                  narrow * (1500 * std::sin(x / 37) * std::cos(y / 23) + 600 * std::sin((x + 2 * y) / 7))));
}

double ridges_m(LonLat place) {
  const double per_degree = (1 << kRidgesFinest) * (kTileSize - 1);
  const double column = (place.lon + 180) * per_degree, row = (place.lat + 90) * per_degree;
  const auto c = static_cast<std::int64_t>(std::floor(column)),
             r = static_cast<std::int64_t>(std::floor(row));
  const double u = column - static_cast<double>(c), v = row - static_cast<double>(r);
  const double sw = ridges(c, r), se = ridges(c + 1, r), nw = ridges(c, r + 1), ne = ridges(c + 1, r + 1);
  const bool rises = ((c ^ r) & 1) == 0;
  const double quanta =
      rises        ? (u >= v ? sw + (se - sw) * u + (ne - se) * v : sw + (ne - nw) * u + (nw - sw) * v)
      : u + v <= 1 ? sw + (se - sw) * u + (nw - sw) * v
                   : ne + (nw - ne) * (1 - u) + (se - ne) * (1 - v);
  return quanta * 0.25;
}

const std::vector<LonLat>& ridge_places() {
  static const std::vector<LonLat> all = {
      {10.31, 45.72}, {179.99, -16.4}, {33, 89.97}, {-70, -89.97}, {0.01, 0.01}};
  return all;
}

std::vector<TileId> ridge_tiles(std::size_t first, std::size_t last) {
  std::vector<TileId> tiles;
  for (std::int32_t y = 0; y < tiles_pole_to_pole(-6); ++y) {
    for (std::int32_t x = 0; x < tiles_around(-6); ++x) tiles.push_back({-6, x, y});
  }
  for (std::size_t i = first; i <= last; ++i) {
    for (int level = -5; level <= kRidgesFinest; ++level) {
      const TileId middle = tile_at(ridge_places()[i], level);
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        for (std::int32_t dx = -1; dx <= 1; ++dx) {
          const TileId near = neighbour_of(middle, dx, dy);
          if (is_valid(near)) tiles.push_back(near);
        }
      }
    }
  }
  return with_ancestors(tiles, kMinLevel);
}

void write_ridge_pack(const std::filesystem::path& path, std::size_t first, std::size_t last) {
  write_test_pack(path, ridge_surface(), ridge_tiles(first, last),
                  [](IndexEntry& entry, HeightTile&) { set_ridge_error(entry); });
}

void write_coloured_pack(const std::filesystem::path& path, const std::vector<TileId>& tiles,
                         TextureFormat format, const ColourAt& colour, Layers layers) {
  Result<PackWriter> writer = PackWriter::create(path, test_header(kTileSize));
  REQUIRE(writer.ok());
  for (const TileId& id : tiles) {
    if (layers == Layers::imagery || id.level > kRidgesFinest) continue;
    const HeightTile heights = ridge_surface().tile(id);
    const auto block = encode_height_block(heights, *height_codecs().front());
    IndexEntry entry = describe(id, heights);
    set_ridge_error(entry);
    REQUIRE(writer->add(entry, block).ok());
  }
  for (const TileId& id : tiles) {
    IndexEntry entry;
    entry.id = id;
    entry.layer = Layer::imagery;
    REQUIRE(writer->add(entry, encode_texture_block(texture_of(id, format, colour))).ok());
  }
  REQUIRE(writer->finish(R"({"bounds":{"west":-180,"south":-90,"east":180,"north":90}})").ok());
}

bool bake_real_pack(const std::filesystem::path& path, const std::vector<std::string>& dems,
                    const std::vector<std::string>& images) {
  const auto data = real_data();
  if (!data) return false;
  BuildOptions options;
  options.mosaic.inputs = below(*data, dems);
  options.imagery.inputs = below(*data, images);
  options.imagery.bounds = GeoBounds{-180, -90, 180, 90};
  options.imagery.quality = TextureQuality::fast;
  options.session.target = path;
  options.grid.tile_size = kTileSize;
  const Result<BuildReport> baked = build(options, [](const Progress&) { return true; });
  if (!baked) FAIL(baked.error().message);
  return true;
}

}  // namespace cairn::test
