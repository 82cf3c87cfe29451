#include "runtime/view/ground_height.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

/// A position along a side: the sample at or before it, and how far it is to the next.
struct GridPosition {
  int index = 0;
  double fraction = 0;
};

GridPosition position(double degrees, double width, int size) {
  const double at = std::clamp(degrees / width, 0.0, 1.0) * (size - 1);
  const int index = std::min(static_cast<int>(at), size - 2);
  return {index, at - index};
}

}  // namespace

std::optional<double> ground_height_m(const HeightTile& tile, const TileId& id, double quantum_m,
                                      LonLat place) {
  const GeoBounds bounds = tile_bounds(id);
  const double turned = std::fmod(place.lon + 180.0, 360.0);
  const double east = (turned < 0 ? turned + 360.0 : turned) - 180.0 - bounds.west;
  const auto [i, u] = position(east, bounds.width(), tile.size);
  const auto [j, v] = position(place.lat - bounds.south, bounds.height(), tile.size);
  const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  double quanta = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const int column = i + (corner & 1), row = j + (corner >> 1);
    if (weights[corner] == 0) continue;
    if (tile.is_void(column, row)) return std::nullopt;
    quanta += weights[corner] * tile.at(column, row);
  }
  return quanta * quantum_m;
}

double highest_ground_m(const PackReader& pack) {
  const auto levels = pack.levels(Layer::heights);
  double highest_m = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; levels && i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::heights || entry.id.level != levels->coarsest) break;
    const double error_m = static_cast<double>(entry.geometric_error_m);
    highest_m = std::max(highest_m, entry.max_quanta * pack.header().quantum_m + error_m);
  }
  return highest_m;
}

}  // namespace cairn
