#include "builder/export/surface_normal.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

/// A height and how far it is from the place of the normal, in ticks.
struct Beside {
  double metres = 0;
  std::int64_t ticks = 0;
};

/// The neighbour, or the place itself where the neighbour is void.
Beside beside(double neighbour, double own, std::int64_t ticks) {
  return std::isnan(neighbour) ? Beside{own, 0} : Beside{neighbour, ticks};
}

double slope(const Beside& low, const Beside& high, double metres_a_tick) {
  const std::int64_t ticks = low.ticks + high.ticks;
  return ticks == 0 ? 0 : (high.metres - low.metres) / (static_cast<double>(ticks) * metres_a_tick);
}

}  // namespace

Result<double> pack_height(const PackPatches& patches, MetreTiles& tiles, std::int64_t x, std::int64_t y,
                           int finest) {
  const auto found = patches.tile_at(x, y, finest);
  if (!found) return std::numeric_limits<double>::quiet_NaN();
  const auto tile = tiles.read(found->entry);
  if (!tile) return tile.error();
  return (*tile)->height_at(found->x, y);
}

Result<SurfacePoint> surface_normal(const PackPatches& patches, MetreTiles& tiles, std::int64_t x,
                                    std::int64_t y) {
  x %= kTicksAround;  // both ends of the antimeridian get equal bits
  const LonLat place = place_of(x, y);
  LocalAxes axes = local_axes(place);
  if (y == 0 || y == kTicksPoleToPole) axes.up = {0, 0, y == 0 ? -1.0 : 1.0};
  const auto found = patches.tile_at(x, y, kMaxLevel);
  if (!found) return SurfacePoint{axes.up, false};
  const auto tile = tiles.read(found->entry);
  if (!tile) return tile.error();
  const double own = (*tile)->height_at(found->x, y);
  if (std::isnan(own)) return SurfacePoint{axes.up, false};
  if (y == 0 || y == kTicksPoleToPole) return SurfacePoint{axes.up, true};
  const int level = found->entry.id.level;
  const std::int64_t step = tile_ticks(level) / ((*tile)->size - 1);
  const auto west = pack_height(patches, tiles, (x - step + kTicksAround) % kTicksAround, y, level);
  const auto east = pack_height(patches, tiles, (x + step) % kTicksAround, y, level);
  const auto south = pack_height(patches, tiles, x, std::max<std::int64_t>(y - step, 0), level);
  const auto north = pack_height(patches, tiles, x, std::min(y + step, kTicksPoleToPole), level);
  for (const auto* height : {&west, &east, &south, &north})
    if (!*height) return height->error();
  const DegreeLengths degree = degree_lengths(place.lat, patches.ellipsoid());
  const double to_east =
      slope(beside(*west, own, step), beside(*east, own, step), std::ldexp(degree.lon_m, -kTickBits));
  const double to_north =
      slope(beside(*south, own, step), beside(*north, own, step), std::ldexp(degree.lat_m, -kTickBits));
  SurfacePoint point;
  point.has_height = true;
  const double length = std::sqrt(1 + to_east * to_east + to_north * to_north);
  for (std::size_t i = 0; i < 3; ++i)
    point.normal[i] = (axes.up[i] - to_east * axes.east[i] - to_north * axes.north[i]) / length;
  return point;
}

}  // namespace cairn
