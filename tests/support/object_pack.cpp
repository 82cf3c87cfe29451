#include "tests/support/object_pack.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <catch2/catch.hpp>

#include "cairn/body.h"
#include "format/height_block.h"
#include "format/pack_writer.h"

namespace cairn::test {
namespace {

TextureTile plain_texture(std::array<std::uint8_t, 3> rgb, int size) {
  const int colour = rgb[0] >> 3 << 11 | rgb[1] >> 2 << 5 | rgb[2] >> 3;
  TextureTile tile{TextureFormat::bc3, size, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, size));
  for (std::size_t block = 0; block < tile.texels.size(); block += 16) {
    tile.texels[block] = tile.texels[block + 1] = std::byte{255};
    for (const std::size_t end : {8, 10}) {
      tile.texels[block + end] = static_cast<std::byte>(colour & 255);
      tile.texels[block + end + 1] = static_cast<std::byte>(colour >> 8);
    }
  }
  return tile;
}

void add_side(ObjectModel& model, const std::array<float, 3>& corner, const std::array<float, 3>& along,
              const std::array<float, 3>& up, const std::array<float, 3>& normal, int n) {
  const auto first = static_cast<std::uint16_t>(model.vertices.size());
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      ModelVertex vertex;
      const float u = static_cast<float>(i) / static_cast<float>(n);
      const float v = static_cast<float>(j) / static_cast<float>(n);
      for (std::size_t c = 0; c < 3; ++c) vertex.position_m[c] = corner[c] + u * along[c] + v * up[c];
      vertex.normal = normal;
      vertex.texture = {u, v};
      model.vertices.push_back(vertex);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto at = [&](int c, int r) { return static_cast<std::uint16_t>(first + r * (n + 1) + c); };
      for (const std::uint16_t index :
           {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)})
        model.indices.push_back(index);
    }
  }
}

void add_box(ObjectModel& model, float half, float top, int n) {
  const float w = 2 * half;
  add_side(model, {-half, -half, 0}, {w, 0, 0}, {0, 0, top}, {0, -1, 0}, n);
  add_side(model, {half, -half, 0}, {0, w, 0}, {0, 0, top}, {1, 0, 0}, n);
  add_side(model, {half, half, 0}, {-w, 0, 0}, {0, 0, top}, {0, 1, 0}, n);
  add_side(model, {-half, half, 0}, {0, -w, 0}, {0, 0, top}, {-1, 0, 0}, n);
  add_side(model, {-half, -half, top}, {w, 0, 0}, {0, w, 0}, {0, 0, 1}, n);
}

struct OwnTile {
  std::vector<PlacedObject> objects;
  float largest_m = 0;  // with those beneath
};

std::map<TileId, OwnTile> tiles_of(const std::vector<TestObject>& objects, const std::vector<float>& sizes_m,
                                   int coarsest) {
  std::map<TileId, OwnTile> tiles;
  for (const TestObject& object : objects) {
    const float size_m = sizes_m[object.placed.model] * static_cast<float>(object.placed.scale_factor());
    const TileId tile = tile_at(object.place, std::max(object_level(size_m, Body()), coarsest));
    const GeoBounds bounds = tile_bounds(tile);
    PlacedObject placed = object.placed;
    placed.x = static_cast<std::uint16_t>((object.place.lon - bounds.west) / bounds.width() * 65536);
    placed.y = static_cast<std::uint16_t>((object.place.lat - bounds.south) / bounds.height() * 65536);
    tiles[tile].objects.push_back(placed);
    for (TileId id = tile;; id = parent_of(id)) {
      tiles[id].largest_m = std::max(tiles[id].largest_m, size_m);
      if (id.level == coarsest) break;
    }
  }
  return tiles;
}

}  // namespace

ObjectModel box_model(const std::string& name, float radius_m, float top_m, std::array<std::uint8_t, 3> rgb,
                      int n) {
  ObjectModel model;
  model.name = name;
  const float half = radius_m / std::sqrt(2.0F);
  add_box(model, half, top_m, n);
  const auto fine = static_cast<std::uint32_t>(model.indices.size());
  model.levels.push_back({0, fine, 0});
  if (n > 1) {
    add_box(model, half, top_m, 1);
    model.levels.push_back({fine, static_cast<std::uint32_t>(model.indices.size()) - fine, 0.5F});
  }
  model.texture = plain_texture(rgb, 4);
  model.billboard_views = kBillboardViews;
  model.billboard = plain_texture(rgb, 64);
  model.radius_m = radius_m;
  model.bottom_m = 0;
  model.top_m = top_m;
  Result<ObjectModel> rounded = decode_model_block(encode_model_block(model));
  if (!rounded) FAIL(rounded.error().message);
  return std::move(*rounded);
}

void write_object_pack(const std::filesystem::path& path, const TestSurface& surface,
                       const std::vector<TileId>& tiles, const std::vector<ObjectModel>& models,
                       const std::vector<TestObject>& objects) {
  Result<PackWriter> writer = PackWriter::create(path, test_header(surface.tile_size));
  REQUIRE(writer.ok());
  int coarsest = kMaxLevel;
  for (const TileId& id : tiles) {
    coarsest = std::min(coarsest, id.level);
    const HeightTile tile = surface.tile(id);
    const IndexEntry entry = describe(id, tile);
    const bool is_constant = (entry.flags & kConstant) != 0;
    const auto block =
        is_constant ? std::vector<std::byte>() : encode_height_block(tile, *height_codecs().front());
    REQUIRE(writer->add(entry, block).ok());
  }
  std::vector<float> sizes_m;
  for (const ObjectModel& model : models) sizes_m.push_back(model.size_m());
  for (auto& [id, own] : tiles_of(objects, sizes_m, coarsest)) {
    IndexEntry entry;
    entry.layer = Layer::objects;
    entry.id = id;
    entry.geometric_error_m = own.largest_m;
    entry.min_quanta = static_cast<std::int32_t>(own.objects.size());
    if (own.objects.empty()) entry.flags = kConstant;
    sort_objects(own.objects);
    const auto block =
        own.objects.empty() ? std::vector<std::byte>() : encode_object_block({0, 0, std::move(own.objects)});
    REQUIRE(writer->add(entry, block).ok());
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    IndexEntry entry;
    entry.layer = Layer::models;
    entry.id = model_address(static_cast<std::uint32_t>(i));
    entry.geometric_error_m = sizes_m[i];
    entry.min_quanta = static_cast<std::int32_t>(models[i].levels[0].count / 3);
    REQUIRE(writer->add(entry, encode_model_block(models[i])).ok());
  }
  REQUIRE(writer->finish(test_metadata(test_header(surface.tile_size), writer->levels())).ok());
}

}  // namespace cairn::test
