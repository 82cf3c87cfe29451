#include "runtime/lod/mesh/nested_spheres.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cairn/geodesy.h"
#include "format/rqt_steps.h"
#include "runtime/surface/vertex_errors.h"

namespace cairn {
namespace {

// Triangles bisected at a middle have their hypotenuse along the grid, those at a centre a diagonal one:
// see sagitta_of_cell_m().
void add_sagittas(int size, double cell, double max_m, const Ellipsoid& ellipsoid,
                  std::vector<float>& errors_m) {
  const double sagitta_m = sagitta_of_cell_m(cell, max_m, ellipsoid);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const int h = (c | r) & -(c | r);
      const bool centre = (c & h) != 0 && (r & h) != 0;
      errors_m[static_cast<std::size_t>(r) * static_cast<std::size_t>(size) + static_cast<std::size_t>(c)] +=
          static_cast<float>(sagitta_m * 4 * h * h * (centre ? 1 : 0.5));
    }
  }
}

// From fine to coarse, each vertex hands its error and sphere to its parents, on which it depends.
void nest(const LodScene& scene, const LodTile& tile, NestedSpheres& out) {
  std::vector<float>&errors_m = out.errors_m, &radii_m = out.radii_m;
  const HeightTile& heights = *tile.heights;
  const double cell = tile_width_degrees(tile.source.level) / (heights.size - 1) * std::numbers::pi / 180;
  const double cell_m = cell * (scene.ellipsoid.semi_major_m + std::max(0.0, tile.max_m));
  add_sagittas(heights.size, cell, tile.max_m, scene.ellipsoid, errors_m);
  // Places of a triangle between samples are at most one cell's diagonal from a sample.
  radii_m.assign(errors_m.size(), static_cast<float>(cell_m * std::numbers::sqrt2));
  std::vector<std::size_t> order;
  std::vector<RqtNeeds> parents;
  for_each_rqt_vertex(heights.size, root_rises(tile.source), [&](std::size_t i, const RqtNeeds& needs) {
    order.push_back(i);
    parents.push_back(needs);
  });
  const auto size = static_cast<std::size_t>(heights.size);
  for (std::size_t n = order.size(); n-- > 0;) {
    const std::size_t i = order[n];
    for (const std::size_t parent : {parents[n].first, parents[n].second}) {
      const double east = (static_cast<double>(i % size) - static_cast<double>(parent % size)) * cell_m;
      const double north = (static_cast<double>(i / size) - static_cast<double>(parent / size)) * cell_m;
      const double up = (static_cast<double>(heights.samples[i]) - heights.samples[parent]) * scene.quantum_m;
      const double reach = std::hypot(east, north, up) * (1 + 1e-6) + static_cast<double>(radii_m[i]);
      radii_m[parent] = std::max(radii_m[parent], std::nextafter(static_cast<float>(reach), HUGE_VALF));
      errors_m[parent] = std::max(errors_m[parent], errors_m[i]);
    }
  }
}

}  // namespace

NestedSpheres::NestedSpheres(const LodScene& scene, const LodTile& tile, bool between)
    : between_samples(between),
      positions(south_west_of(tile.source), lattice_width(tile.source.level) / (scene.tile_size - 1),
                scene.tile_size, scene.ellipsoid),
      errors_m(vertex_errors_m(*tile.heights, tile.source, scene.quantum_m, between)) {
  nest(scene, tile, *this);
}

}  // namespace cairn
