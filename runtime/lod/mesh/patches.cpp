#include "runtime/lod/mesh/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_set>

#include "cairn/geodesy.h"
#include "runtime/lod/mesh/index_forms.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {
namespace {

struct Heights {
  double low = 0;
  double high = 0;
};

Heights heights_of(const TileWindow& window, const Patch& patch, double quantum_m) {
  std::int32_t low = window.quanta(patch.column, patch.row), high = low;
  for (int r = patch.row; r <= patch.row + patch.cells; ++r) {
    for (int c = patch.column; c <= patch.column + patch.cells; ++c) {
      low = std::min(low, window.quanta(c, r));
      high = std::max(high, window.quanta(c, r));
    }
  }
  return {low * quantum_m, high * quantum_m};
}

GeoBounds bounds_of(const TileWindow& window, const Patch& patch) {
  const LonLat low = place_of(window.point(patch.column, patch.row));
  const LonLat high = place_of(window.point(patch.column + patch.cells, patch.row + patch.cells));
  return {low.lon, low.lat, high.lon, high.lat};
}

/// Returns the largest error of the samples in one cell of the decimated grid, in quanta.
double cell_error(const TileWindow& window, int column, int row, int step) {
  const double sw = window.quanta(column, row), se = window.quanta(column + step, row);
  const double nw = window.quanta(column, row + step), ne = window.quanta(column + step, row + step);
  double worst = 0;
  for (int j = 0; j <= step; ++j) {
    for (int i = 0; i <= step; ++i) {
      const double u = static_cast<double>(i) / step, v = static_cast<double>(j) / step;
      const double at = u >= v ? sw + u * (se - sw) + v * (ne - se) : sw + v * (nw - sw) + u * (ne - nw);
      worst = std::max(worst, std::abs(at - window.quanta(column + i, row + j)));
    }
  }
  return worst;
}

double sagitta_of_grid_m(const TileWindow& window, const Patch& patch, int step, const Ellipsoid& ellipsoid) {
  const GeoBounds bounds = bounds_of(window, patch);
  const double radian = std::numbers::pi / 180;
  const double angle = bounds.width() * radian * step / patch.cells;
  const double nearest = bounds.south > 0 ? bounds.south : bounds.north < 0 ? bounds.north : 0;
  const double cosine = std::cos(nearest * radian);
  return ellipsoid.semi_major_m * angle * angle * (1 + cosine * cosine) / 8;
}

}  // namespace

std::vector<float> patch_errors_m(const LodScene& scene, const LodTile& tile, const Patch& patch, int steps) {
  const TileWindow window(scene, tile);
  std::vector<float> errors;
  for (int k = 0; k < steps && 1 << k <= patch.cells; ++k) {
    const int step = 1 << k;
    double worst = 0;
    for (int r = patch.row; r < patch.row + patch.cells && k > 0; r += step) {
      for (int c = patch.column; c < patch.column + patch.cells; c += step) {
        worst = std::max(worst, cell_error(window, c, r, step));
      }
    }
    const double sagitta_m = k > 0 ? sagitta_of_grid_m(window, patch, step, scene.ellipsoid) : 0;
    errors.push_back(static_cast<float>(worst * scene.quantum_m + sagitta_m));
  }
  return errors;
}

std::vector<Patch> Patches::make(const LodScene& scene, const LodTile& tile) const {
  const TileWindow window(scene, tile);
  const Occluder occluder(scene.lowest_m, scene.ellipsoid);
  const int cells = std::min(cells_, window.cells());
  std::vector<Patch> patches;
  for (int row = 0; row < window.cells(); row += cells) {
    for (int column = 0; column < window.cells(); column += cells) {
      Patch patch{column, row, cells, {}, {}};
      const Heights heights = heights_of(window, patch, scene.quantum_m);
      patch.volume = bounding_volume(bounds_of(window, patch), heights.low, heights.high, occluder);
      patch.errors_m = patch_errors_m(scene, tile, patch, error_steps_);
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

void Patches::prepare(const LodScene& scene) {
  std::unordered_set<TileId> areas;
  for (const LodTile& tile : scene.tiles) areas.insert(tile.area);
  std::erase_if(kept_, [&](const auto& item) { return !areas.contains(item.first); });
  for (const LodTile& tile : scene.tiles) {
    Kept& kept = kept_[tile.area];
    if (kept.patches.empty() || kept.source != tile.source) kept = {tile.source, make(scene, tile)};
  }
}

std::uint64_t Patches::bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& [area, kept] : kept_) {
    for (const Patch& patch : kept.patches) bytes += sizeof(Patch) + patch.errors_m.size() * sizeof(float);
  }
  return bytes;
}

namespace {

/// Draws chosen patches, each joined to neighbours of its own size and spacing.
class PatchMesher {
 public:
  PatchMesher(const LodScene& scene, std::span<const ChosenPatch> chosen) : scene_(scene), chosen_(chosen) {
    for (std::size_t i = 0; i < chosen.size(); ++i) by_corner_.emplace(corner_of(chosen[i]), i);
  }

  void append(std::size_t index, LodTileMesh& mesh) const {
    const ChosenPatch& chosen = chosen_[index];
    const TileWindow window(scene_, scene_.tiles[chosen.tile]);
    const int step = 1 << chosen.detail.step, side = chosen.patch->cells / step + 1;
    const std::array<Rim, 4> rims{rim_beside(index, 0, -1), rim_beside(index, 0, 1), rim_beside(index, -1, 0),
                                  rim_beside(index, 1, 0)};
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    std::vector<std::uint32_t> numbers;
    for (int r = 0; r < side; ++r) {
      for (int c = 0; c < side; ++c) {
        int column = c * step, row = r * step;
        Rim at{step, chosen.detail.morph};
        if (r == 0) column = moved(column, (at = rims[0]).step);
        if (r == side - 1) column = moved(column, (at = rims[1]).step);
        if (c == 0) row = moved(row, (at = rims[2]).step);
        if (c == side - 1) row = moved(row, (at = rims[3]).step);
        mesh.vertices.push_back(morphed(window, *chosen.patch, column, row, at));
        numbers.push_back(first + number_of(column / step, row / step, side));
      }
    }
    for (const LodTriangle& t : triangles_of(side)) {
      const LodTriangle drawn{numbers[t[0]], numbers[t[1]], numbers[t[2]]};
      if (drawn[0] == drawn[1] || drawn[1] == drawn[2] || drawn[0] == drawn[2]) continue;
      mesh.triangles.push_back(drawn);
    }
  }

 private:
  static std::uint32_t number_of(int column, int row, int side) {
    return static_cast<std::uint32_t>(row * side + column);
  }

  /// Returns the nearest place at which the neighbour has a vertex too.
  static int moved(int along, int step) { return (along + step / 2) / step * step; }

  LatticePoint corner_of(const ChosenPatch& chosen) const {
    const TileWindow window(scene_, scene_.tiles[chosen.tile]);
    return canonical(window.point(chosen.patch->column, chosen.patch->row));
  }

  /// The vertices that a patch and the one beside it have in common.
  struct Rim {
    int step;  ///< in samples
    double morph;
  };

  Rim rim_beside(std::size_t index, int dx, int dy) const {
    const ChosenPatch& mine = chosen_[index];
    const TileWindow window(scene_, scene_.tiles[mine.tile]);
    LatticePoint corner = corner_of(mine);
    corner.x = (corner.x + dx * mine.patch->cells * window.spacing() + kLatticeAround) % kLatticeAround;
    corner.y += dy * mine.patch->cells * window.spacing();
    const int own = 1 << mine.detail.step;
    const auto it = by_corner_.find(corner);
    if (it == by_corner_.end()) return {own, 0};
    const ChosenPatch& other = chosen_[it->second];
    const TileWindow beside(scene_, scene_.tiles[other.tile]);
    if (other.patch->cells != mine.patch->cells || beside.spacing() != window.spacing()) return {own, 0};
    if (other.detail.step == mine.detail.step) return {own, std::max(mine.detail.morph, other.detail.morph)};
    const PatchDetail& coarser = other.detail.step > mine.detail.step ? other.detail : mine.detail;
    return {1 << coarser.step, coarser.morph};
  }

  /// Returns the vertex with the height between its own and that of the next coarser grid, whose diagonals
  /// run from south-west to north-east. A patch's corners are in all of its grids.
  static LodVertex morphed(const TileWindow& window, const Patch& patch, int column, int row,
                           const Rim& rim) {
    const int c = patch.column + column, r = patch.row + row;
    LodVertex vertex = window.vertex(c, r);
    if (rim.morph <= 0 || 2 * rim.step > patch.cells) return vertex;
    const int dx = column & rim.step, dy = row & rim.step;
    const double coarse_m = (window.height_m(c - dx, r - dy) + window.height_m(c + dx, r + dy)) / 2;
    vertex.height_m += rim.morph * (coarse_m - vertex.height_m);
    return vertex;
  }

  /// A grid's strip is made once per size, as Vaněk & Ježek (2004) precompute one index buffer per level.
  const std::vector<LodTriangle>& triangles_of(int side) const {
    std::vector<LodTriangle>& made = triangles_[side];
    if (made.empty()) made = triangles_of_strip(grid_indices(IndexForm::degenerate_strip, side, side));
    return made;
  }

  const LodScene& scene_;
  std::span<const ChosenPatch> chosen_;
  std::unordered_map<LatticePoint, std::size_t> by_corner_;
  mutable std::unordered_map<int, std::vector<LodTriangle>> triangles_;
};

}  // namespace

void append_patches(const LodScene& scene, std::span<const ChosenPatch> chosen, LodMesh& mesh) {
  const PatchMesher mesher(scene, chosen);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (mesh.tiles.empty() || mesh.tiles.back().tile != chosen[i].tile) {
      mesh.tiles.push_back({chosen[i].tile, {}, {}});
    }
    mesher.append(i, mesh.tiles.back());
    const int side = (chosen[i].patch->cells >> chosen[i].detail.step) + 1;
    for (const IndexForm form : {IndexForm::list, IndexForm::strip, IndexForm::degenerate_strip}) {
      mesh.count(form, grid_index_count(form, side, side));
    }
  }
}

}  // namespace cairn
