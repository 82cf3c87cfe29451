#include "tests/support/lod_scene.h"

#include <algorithm>
#include <cmath>

namespace cairn::test {

LodScenes::LodScenes(bool shifted_fillers) : shifted_fillers_(shifted_fillers) {
  surface_.tile_size = kTileSize;
  surface_.finest = kFinest;
  surface_.height = hills;
  if (shifted_fillers) {
    surface_.is_void = [](std::int64_t column, std::int64_t row) {
      return (column / 64 + row / 64) % 3 == 0;
    };
  }
}

LodScene LodScenes::around(LonLat middle, std::mt19937& random) {
  LodScene scene{kTileSize, 0.25, 0, {}};
  const TileId home = tile_at(middle, 1);
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const TileId id = neighbour_of(home, dx, dy);
      if (is_valid(id)) split(id, id, random, scene);
    }
  }
  std::sort(scene.tiles.begin(), scene.tiles.end(),
            [](const LodTile& a, const LodTile& b) { return a.area < b.area; });
  return scene;
}

void LodScenes::split(const TileId& area, const TileId& source, std::mt19937& random, LodScene& scene) {
  const bool leaf = area.level == kFinest || random() % 10 >= 3;
  if (leaf) return scene.tiles.push_back(tile(area, source));
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    split(child, random() % 4 == 0 ? source : child, random, scene);
  }
}

LodTile LodScenes::tile(const TileId& area, const TileId& source) {
  LodTile tile;
  tile.area = area;
  tile.source = source;
  tile.heights = heights(source);
  const auto [low, high] = std::minmax_element(tile.heights->samples.begin(), tile.heights->samples.end());
  tile.min_m = *low * 0.25;
  tile.max_m = *high * 0.25;
  tile.volume = bounding_volume(tile_bounds(area), tile.min_m, tile.max_m, Occluder(0));
  return tile;
}

std::shared_ptr<const HeightTile> LodScenes::heights(const TileId& id) {
  auto& kept = heights_[id];
  if (kept) return kept;
  HeightTile made = surface_.tile(id);
  for (std::size_t i = 0; i < made.voids.size() && shifted_fillers_; ++i) {
    if (made.voids[i] != 0) made.samples[i] += id.level * 3 + id.x % 5;
  }
  return kept = std::make_shared<const HeightTile>(std::move(made));
}

std::optional<MeshPlace> find_on(const LodMesh& mesh, const LatticePoint& place) {
  const auto cross = [](const LatticePoint& o, const LatticePoint& a, const LatticePoint& b) {
    return static_cast<double>(a.x - o.x) * static_cast<double>(b.y - o.y) -
           static_cast<double>(b.x - o.x) * static_cast<double>(a.y - o.y);
  };
  for (const LodTileMesh& tile : mesh.tiles) {
    for (const LodTriangle& t : tile.triangles) {
      const LodVertex &a = tile.vertices[t[0]], &b = tile.vertices[t[1]], &c = tile.vertices[t[2]];
      const double u = cross(place, b.point, c.point), v = cross(place, c.point, a.point),
                   w = cross(place, a.point, b.point), sum = u + v + w;
      if (u >= 0 && v >= 0 && w >= 0) return MeshPlace{{a, b, c}, {u / sum, v / sum, w / sum}};
    }
  }
  return std::nullopt;
}

ViewState random_view(LonLat near, std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  ViewState view;
  view.eye = {near.lon + between(-0.6, 0.6), std::clamp(near.lat + between(-0.6, 0.6), -90.0, 90.0)};
  view.height_m = 1500 + std::pow(10.0, between(1, 6));
  view.heading_deg = between(0, 360);
  view.pitch_deg = between(-90, 10);
  return view;
}

}  // namespace cairn::test
