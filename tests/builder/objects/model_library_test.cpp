// What a mesh becomes as a model: levels of detail, one texture, bounds, and pictures from eight sides.
#include "builder/objects/model_library.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "format/block_texture.h"

namespace cairn::test {
namespace {

constexpr float kRadius = 5;

/// A sphere that stands on its origin, red where it faces north and blue where it faces south.
SourceMesh two_coloured_sphere(int columns, int rows) {
  SourceMesh mesh;
  mesh.palette = {{{220, 30, 30, 255}, SourceMesh::kNoImage}, {{30, 30, 220, 255}, SourceMesh::kNoImage}};
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= columns; ++c) {
      const double up = std::numbers::pi * (static_cast<double>(r) / rows - 0.5);
      const double around = 2 * std::numbers::pi * (c % columns) / columns;
      SourceMesh::Vertex vertex;
      vertex.normal = {static_cast<float>(std::cos(up) * std::cos(around)),
                       static_cast<float>(std::cos(up) * std::sin(around)), static_cast<float>(std::sin(up))};
      for (std::size_t i = 0; i < 3; ++i) vertex.position[i] = kRadius * vertex.normal[i];
      vertex.position[2] += kRadius;
      mesh.vertices.push_back(vertex);
    }
  }
  const auto at = [&](int c, int r) { return static_cast<std::uint32_t>(r * (columns + 1) + c); };
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      for (const std::uint32_t i :
           {at(c, r), at(c + 1, r), at(c + 1, r + 1), at(c, r), at(c + 1, r + 1), at(c, r + 1)})
        mesh.indices.push_back(i);
      for (int i = 0; i < 2; ++i) mesh.materials.push_back(c < columns / 2 ? 0 : 1);
    }
  }
  return mesh;
}

std::vector<std::uint8_t> texels_of(const TextureTile& tile) {
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(tile.size) * static_cast<std::size_t>(tile.size) *
                                 4);
  REQUIRE(decode_texture(tile.format,
                         std::span(tile.texels).first(texture_image_bytes(tile.format, tile.size)), tile.size,
                         tile.size, rgba));
  return rgba;
}

double off_the_sphere(const ObjectModel& model, const ModelLevel& level) {
  double largest = 0;
  for (std::uint32_t i = level.first; i < level.first + level.count; i += 3) {
    std::array<double, 3> middle{};
    for (std::uint32_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j)
        middle[j] += static_cast<double>(model.vertices[model.indices[i + k]].position_m[j]) / 3;
    }
    largest = std::max(largest,
                       std::abs(std::hypot(middle[0], middle[1], middle[2] - static_cast<double>(kRadius)) -
                                static_cast<double>(kRadius)));
  }
  return largest;
}

}  // namespace

TEST_CASE("a model's levels have fewer and fewer triangles, and the finest is the mesh") {
  const auto model = make_model("ball", two_coloured_sphere(64, 32));
  REQUIRE(model);
  REQUIRE(model->levels.size() >= 3);
  CHECK(model->levels[0].error_m == 0);
  CHECK(model->levels[0].count == 3 * 64 * 32 * 2);
  const double finest = off_the_sphere(*model, model->levels[0]);
  CHECK(finest < 0.02);
  for (std::size_t l = 1; l < model->levels.size(); ++l) {
    CHECK(model->levels[l].count * 5 <= model->levels[l - 1].count * 4);
    CHECK(model->levels[l].error_m >= model->levels[l - 1].error_m);
    CHECK(model->levels[l].error_m > 0);
    // Quadrics weigh by area, so that the middle of a triangle may be off by some more.
    CHECK(off_the_sphere(*model, model->levels[l]) <=
          finest + 3 * static_cast<double>(model->levels[l].error_m));
  }
  CHECK(model->radius_m == Approx(kRadius).margin(0.02));
  CHECK(model->top_m == Approx(2 * kRadius).margin(1e-3));
  CHECK(model->bottom_m == Approx(0).margin(1e-3));
  const auto again = decode_model_block(encode_model_block(*model));
  REQUIRE(again);
  CHECK(again->levels == model->levels);
}

TEST_CASE("each triangle has its material's colour in the one texture") {
  const auto model = make_model("ball", two_coloured_sphere(24, 12));
  REQUIRE(model);
  const auto texels = texels_of(model->texture);
  const int size = model->texture.size;
  const ModelLevel& level = model->levels[0];
  std::size_t reds = 0;
  for (std::uint32_t i = level.first; i < level.first + level.count; i += 3) {
    double north = 0;
    std::array<double, 2> place{};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const ModelVertex& vertex = model->vertices[model->indices[i + k]];
      north += static_cast<double>(vertex.position_m[1]);
      for (std::size_t j = 0; j < 2; ++j) place[j] += static_cast<double>(vertex.texture[j]) / 3;
    }
    const auto column = std::clamp(static_cast<int>(place[0] * size), 0, size - 1);
    const auto row = std::clamp(static_cast<int>(place[1] * size), 0, size - 1);
    const std::uint8_t* texel = &texels[4 * static_cast<std::size_t>(row * size + column)];
    if (std::abs(north) > 1e-3) CHECK((texel[0] > texel[2]) == (north > 0));  // not those without an area
    reds += texel[0] > texel[2] ? 1u : 0u;
  }
  CHECK(reds * 2 == level.count / 3);
}

TEST_CASE("a billboard shows the side that the eye is on") {
  const auto model = make_model("ball", two_coloured_sphere(24, 12));
  REQUIRE(model);
  REQUIRE(model->billboard_views == kBillboardViews);
  const auto texels = texels_of(model->billboard);
  const int size = model->billboard.size, width = size / 4, height = size / 2;
  for (int view = 0; view < kBillboardViews; ++view) {
    const auto texel = [&](double x, double y) {
      const int column = (view % 4) * width + static_cast<int>(x * width),
                row = (view / 4) * height + static_cast<int>(y * height);
      return &texels[4 * static_cast<std::size_t>(row * size + column)];
    };
    INFO("view " << view);
    CHECK(texel(0.5, 0.5)[3] == 255);
    CHECK(texel(0.02, 0.02)[3] < 128);
    // From north all is red, from south blue; from east, view 2, the right half is north.
    if (view == 0 || view == 1 || view == 7) CHECK(texel(0.5, 0.5)[0] > 150);
    if (view == 3 || view == 4 || view == 5) CHECK(texel(0.5, 0.5)[2] > 150);
    if (view == 2) CHECK((texel(0.75, 0.5)[0] > 150 && texel(0.25, 0.5)[2] > 150));
    if (view == 6) CHECK((texel(0.25, 0.5)[0] > 150 && texel(0.75, 0.5)[2] > 150));
  }
}

TEST_CASE("a mesh of another process that is cut is refused, and one with a changed byte crashes nothing") {
  const auto bytes = encode_mesh(two_coloured_sphere(6, 4));
  REQUIRE(decode_mesh(bytes));
  for (std::size_t n = 0; n < bytes.size(); ++n) REQUIRE(!decode_mesh(std::span(bytes).first(n)));
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    auto changed = bytes;
    changed[n] ^= std::byte{0x81};
    const auto mesh = decode_mesh(changed);
    if (!mesh) continue;
    for (const std::uint32_t index : mesh->indices) REQUIRE(index < mesh->vertices.size());
    for (const std::uint32_t material : mesh->materials) REQUIRE(material < mesh->palette.size());
  }
}

TEST_CASE("a mesh without an area or of no size is refused") {
  SourceMesh line;
  line.vertices.resize(3);
  line.indices = {0, 1, 2};
  line.materials = {0};
  line.palette.resize(1);
  CHECK(!make_model("line", line));
  for (std::size_t i = 0; i < 3; ++i)
    line.vertices[i].position = {i == 1 ? 1e-6F : 0.0F, i == 2 ? 1e-6F : 0.0F, 0.0F};
  CHECK(!make_model("dust", line));
}

}  // namespace cairn::test
