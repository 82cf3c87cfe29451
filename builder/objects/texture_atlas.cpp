#include "builder/objects/texture_atlas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace cairn {
namespace {

constexpr int kMostCell = 1024;
constexpr int kLeastCell = 4;
constexpr int kMostAtlas = 2048;
constexpr int kLeastAtlas = 16;
constexpr double kSlack = 1e-3;  // of a repeat beyond the picture's edge, which is rounding

/// A material's place in the atlas, and what of the repeated picture it shows.
struct Cell {
  int x = 0, y = 0, width = kLeastCell, height = kLeastCell;
  std::array<double, 2> first{};  // of the repeats
  std::array<double, 2> repeats{1, 1};
};

/// By vertex; the last material for one without triangles.
std::vector<std::uint32_t> materials_of_vertices(const SourceMesh& mesh) {
  std::vector<std::uint32_t> materials(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) materials[mesh.indices[i]] = mesh.materials[i / 3];
  return materials;
}

void measure_repeats(const SourceMesh& mesh, const std::vector<std::uint32_t>& materials,
                     std::vector<Cell>& cells) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, 2>> low(cells.size(), {kNone, kNone}), high(cells.size(), {-kNone, -kNone});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double at = static_cast<double>(mesh.vertices[v].texture[i]);
      low[materials[v]][i] = std::min(low[materials[v]][i], at);
      high[materials[v]][i] = std::max(high[materials[v]][i], at);
    }
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (std::size_t i = 0; i < 2; ++i) {
      if (low[c][i] > high[c][i]) continue;
      cells[c].first[i] = std::floor(low[c][i] + kSlack);
      cells[c].repeats[i] = std::max(1.0, std::ceil(high[c][i] - kSlack) - cells[c].first[i]);
    }
  }
}

void choose_sizes(const SourceMesh& mesh, std::vector<Cell>& cells) {
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto image = mesh.palette[c].image;
    if (image == SourceMesh::kNoImage) continue;
    const auto texels = [](double size) {
      return power_of_two_within(static_cast<int>(std::min(size, 65536.0)), kLeastCell, kMostCell);
    };
    cells[c].width = texels(mesh.images[image].width * cells[c].repeats[0]);
    cells[c].height = texels(mesh.images[image].height * cells[c].repeats[1]);
  }
}

/// Rows of cells, the highest first. All sizes are powers of 2, so that each cell starts at a multiple of its
/// own.
bool place_cells(std::vector<Cell>& cells, int size) {
  std::vector<std::size_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(cells[a].height, cells[a].width) > std::pair(cells[b].height, cells[b].width);
  });
  int x = 0, y = 0, row = 0;
  for (const std::size_t c : order) {
    Cell& cell = cells[c];
    if (x + cell.width > size) {
      y += row;
      x = row = 0;
    }
    row = std::max(row, cell.height);
    if (cell.width > size || y + row > size) return false;
    cell.x = x;
    cell.y = y;
    x += cell.width;
  }
  return true;
}

int place_all(std::vector<Cell>& cells) {
  for (;;) {
    for (int size = kLeastAtlas; size <= kMostAtlas; size *= 2)
      if (place_cells(cells, size)) return size;
    for (Cell& cell : cells) {
      cell.width = std::max(1, cell.width / 2);
      cell.height = std::max(1, cell.height / 2);
    }
  }
}

std::uint8_t product(std::uint8_t a, std::uint8_t b) {
  return static_cast<std::uint8_t>((a * b + 127) / 255);
}

void draw_cell(const SourceMesh& mesh, const SourceMesh::Material& material, const Cell& cell,
               Picture& atlas) {
  Picture once = Picture::filled(1, 1, {255, 255, 255, 255});
  if (material.image != SourceMesh::kNoImage) {
    const SourceMesh::Image& image = mesh.images[material.image];
    const auto texels = [](int size, double repeats) {
      return std::max(1, static_cast<int>(size / repeats));
    };
    once = resized({static_cast<int>(image.width), static_cast<int>(image.height), image.rgba},
                   texels(cell.width, cell.repeats[0]), texels(cell.height, cell.repeats[1]));
  }
  const auto wrapped = [](int texel, int cell_size, double repeats, int size) {
    const double at = (texel + 0.5) / cell_size * repeats;
    return std::min(size - 1, static_cast<int>((at - std::floor(at)) * size));
  };
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x) {
      const std::uint8_t* from = once.at(wrapped(x, cell.width, cell.repeats[0], once.width),
                                         wrapped(y, cell.height, cell.repeats[1], once.height));
      for (int i = 0; i < 4; ++i)
        atlas.at(cell.x + x, cell.y + y)[i] = product(from[i], material.colour[static_cast<std::size_t>(i)]);
    }
  }
}

}  // namespace

void split_by_material(SourceMesh& mesh) {
  constexpr std::uint32_t kNobody = UINT32_MAX;
  std::vector<std::uint32_t> owner(mesh.vertices.size(), kNobody);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    std::uint32_t& index = mesh.indices[i];
    const std::uint32_t material = mesh.materials[i / 3];
    if (owner[index] == kNobody) owner[index] = material;
    if (owner[index] == material) continue;
    const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto [copy, is_new] = copies.try_emplace({index, material}, next);
    if (is_new) {
      mesh.vertices.push_back(mesh.vertices[index]);
      owner.push_back(material);
    }
    index = copy->second;
  }
}

TextureAtlas make_atlas(const SourceMesh& mesh) {
  std::vector<Cell> cells(mesh.palette.size());
  const std::vector<std::uint32_t> materials = materials_of_vertices(mesh);
  measure_repeats(mesh, materials, cells);
  choose_sizes(mesh, cells);
  const int size = place_all(cells);
  TextureAtlas atlas;
  atlas.picture = Picture::filled(size, size, {0, 0, 0, 255});
  for (std::size_t c = 0; c < cells.size(); ++c) draw_cell(mesh, mesh.palette[c], cells[c], atlas.picture);
  // From the middle of a cell's first texel to that of its last, so that its neighbours do not show.
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Cell& cell = cells[materials[v]];
    const auto place = [&](std::size_t i, int start, int texels) {
      const double at = (static_cast<double>(mesh.vertices[v].texture[i]) - cell.first[i]) / cell.repeats[i];
      return static_cast<float>((start + 0.5 + std::clamp(at, 0.0, 1.0) * (texels - 1)) / size);
    };
    atlas.texture.push_back({place(0, cell.x, cell.width), place(1, cell.y, cell.height)});
  }
  return atlas;
}

}  // namespace cairn
