#include "tests/support/test_objects.h"

#include <array>
#include <cmath>
#include <random>
#include <utility>

namespace cairn::test {
namespace {

TextureTile random_texture(TextureFormat format, int size, unsigned seed) {
  std::mt19937 random(seed);
  TextureTile texture{format, size, std::vector<std::byte>(texture_chain_bytes(format, size))};
  for (std::byte& b : texture.texels) b = static_cast<std::byte>(random() % 7);
  return texture;
}

// Four corners, seen from where `normal` points to.
void add_face(ObjectModel& model, const std::array<float, 3>& normal, const std::array<float, 3>& middle,
              const std::array<float, 3>& right, const std::array<float, 3>& up) {
  const auto first = static_cast<std::uint16_t>(model.vertices.size());
  for (const auto& [r, u] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
    ModelVertex vertex;
    for (std::size_t i = 0; i < 3; ++i) vertex.position_m[i] = middle[i] + r * right[i] + u * up[i];
    vertex.normal = normal;
    vertex.texture = {(r + 1) / 2, (1 - u) / 2};
    model.vertices.push_back(vertex);
  }
  for (const int corner : {0, 1, 2, 0, 2, 3})
    model.indices.push_back(static_cast<std::uint16_t>(first + corner));
}

}  // namespace

ObjectModel box_model(const std::string& name, float width_m, float height_m) {
  const float w = width_m / 2;
  const float h = height_m / 2;
  ObjectModel model;
  model.name = name;
  add_face(model, {0, 0, 1}, {0, 0, height_m}, {w, 0, 0}, {0, w, 0});
  add_face(model, {0, -1, 0}, {0, -w, h}, {w, 0, 0}, {0, 0, h});
  add_face(model, {1, 0, 0}, {w, 0, h}, {0, w, 0}, {0, 0, h});
  add_face(model, {0, 1, 0}, {0, w, h}, {-w, 0, 0}, {0, 0, h});
  add_face(model, {-1, 0, 0}, {-w, 0, h}, {0, -w, 0}, {0, 0, h});
  model.levels.push_back({0, static_cast<std::uint32_t>(model.indices.size()), 0});
  const std::vector<std::uint16_t> top(model.indices.begin(), model.indices.begin() + 6);
  model.levels.push_back({model.levels[0].count, 6, height_m});
  model.indices.insert(model.indices.end(), top.begin(), top.end());
  model.radius_m = w * std::sqrt(2.0f);
  model.top_m = height_m;
  model.texture = random_texture(TextureFormat::bc1, 8, 1);
  model.billboard_views = kBillboardViews;
  model.billboard = random_texture(TextureFormat::bc3, 32, 2);
  return model;
}

ObjectModel picture_model(const std::string& name, float width_m, float height_m) {
  ObjectModel model;
  model.name = name;
  model.radius_m = width_m / 2;
  model.top_m = height_m;
  model.billboard_views = 1;
  model.billboard = random_texture(TextureFormat::bc3, 16, 3);
  return model;
}

ObjectTile random_objects(std::size_t count, std::uint16_t models, unsigned seed) {
  std::mt19937 random(seed);
  ObjectTile tile{-20, 400, std::vector<PlacedObject>(count)};
  for (PlacedObject& object : tile.objects) {
    object.model = static_cast<std::uint16_t>(random() % models);
    object.x = static_cast<std::uint16_t>(random());
    object.y = static_cast<std::uint16_t>(random());
    object.heading = static_cast<std::uint16_t>(random());
    object.scale = static_cast<std::uint16_t>(4096 + random() % 2048);
    if (random() % 10 == 0) object.height_quanta = static_cast<std::int32_t>(random());
  }
  sort_objects(tile.objects);
  return tile;
}

}  // namespace cairn::test
