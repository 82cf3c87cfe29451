#include "runtime/surface/normal_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

#include "cairn/geodesy.h"
#include "runtime/surface/bc5.h"

namespace cairn {
namespace {

struct Slopes {
  float east = 0;
  float north = 0;
  float up = 1;
};

/// Metres between two columns and two rows of samples, on the sphere of the equator's radius: off by two
/// flattenings at most, which shading does not show.
struct Spacing {
  double east = 0;
  double north = 0;
};
Spacing spacing_of_row(const TileId& id, int row, int cells, double radius_m) {
  const double radian = std::numbers::pi / 180;
  const double step = tile_width_degrees(id.level) / cells * radian;
  const double lat = (id.y * tile_width_degrees(id.level) - 90) * radian + (row + 0.5) * step;
  return {radius_m * step * std::max(std::cos(lat), 1e-6), radius_m * step};
}

std::vector<Slopes> cell_normals(const TileId& id, const HeightTile& tile, double quantum_m,
                                 double radius_m) {
  const int cells = tile.size - 1;
  std::vector<Slopes> normals;
  normals.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (int r = 0; r < cells; ++r) {
    const Spacing spacing = spacing_of_row(id, r, cells, radius_m);
    const auto per_east = static_cast<float>(quantum_m / (2 * spacing.east));
    const auto per_north = static_cast<float>(quantum_m / (2 * spacing.north));
    for (int c = 0; c < cells; ++c) {
      const float sw = static_cast<float>(tile.at(c, r)), se = static_cast<float>(tile.at(c + 1, r));
      const float nw = static_cast<float>(tile.at(c, r + 1)), ne = static_cast<float>(tile.at(c + 1, r + 1));
      const float dx = (se + ne - sw - nw) * per_east, dy = (nw + ne - sw - se) * per_north;
      const float scale = 1 / std::sqrt(dx * dx + dy * dy + 1);
      normals.push_back({-dx * scale, -dy * scale, scale});
    }
  }
  return normals;
}

std::vector<Slopes> halved(std::span<const Slopes> fine, int size) {
  std::vector<Slopes> coarse;
  const auto row_size = static_cast<std::size_t>(size);
  coarse.reserve(row_size * row_size / 4);
  for (std::size_t r = 0; r < row_size; r += 2) {
    for (std::size_t c = 0; c < row_size; c += 2) {
      Slopes sum{0, 0, 0};
      for (const std::size_t at :
           {r * row_size + c, r * row_size + c + 1, (r + 1) * row_size + c, (r + 1) * row_size + c + 1}) {
        sum = {sum.east + fine[at].east, sum.north + fine[at].north, sum.up + fine[at].up};
      }
      const float scale = 1 / std::sqrt(sum.east * sum.east + sum.north * sum.north + sum.up * sum.up);
      coarse.push_back({sum.east * scale, sum.north * scale, sum.up * scale});
    }
  }
  return coarse;
}

std::int8_t quantised(float value) {
  return static_cast<std::int8_t>(std::lround(value * 127));
}

}  // namespace

std::vector<std::byte> normal_map(const TileId& id, const HeightTile& tile, double quantum_m,
                                  const Ellipsoid& ellipsoid) {
  std::vector<Slopes> normals = cell_normals(id, tile, quantum_m, ellipsoid.semi_major_m);
  std::vector<std::byte> blocks;
  std::vector<SignedPair> texels;
  int size = tile.size - 1;
  for (int mip = 0; mip < kNormalMips; ++mip, size /= 2) {
    if (mip > 0) normals = halved(normals, size * 2);
    texels.clear();
    for (const Slopes& n : normals) texels.push_back({quantised(n.east), quantised(n.north)});
    append_bc5(texels, size, blocks);
  }
  return blocks;
}

}  // namespace cairn
