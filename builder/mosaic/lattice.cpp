#include "builder/mosaic/lattice.h"

#include <cmath>

namespace cairn {
namespace {

constexpr double kCoincide = 1e-4;  // of a post; a slope of 45° turns it into 9 mm at 3"

// Of a post: how far a restored spacing may move one. At a slope of 45° it is a fifth of the default error
// bound of whole metres at 3", and likewise for finer heights.
constexpr double kDriftOfMetres = 1e-3, kDrift = 1e-4;

// How many posts `b`'s origin lies past `a`'s, where both have the same spacing; nullopt where no posts
// coincide.
std::optional<std::int64_t> offset_between(const LatticeAxis& a, const LatticeAxis& b) {
  if (a.posts_per_degree != b.posts_per_degree) return std::nullopt;
  const double difference = b.phase - a.phase;
  const double whole = std::round(difference);
  if (std::abs(difference - whole) > kCoincide) return std::nullopt;
  return static_cast<std::int64_t>(whole);
}

}  // namespace

std::optional<std::int64_t> Lattice::posts_around() const {
  const double around = 360.0 * lon.posts_per_degree;
  if (std::abs(around - std::round(around)) > kCoincide) return std::nullopt;
  return std::llround(around);
}

std::optional<LatticePlacement> place_on_lattice(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  if (!g.is_lattice()) return std::nullopt;
  const double south = g.dy > 0 ? g.y0 : g.y0 + g.dy * static_cast<double>(info.rows - 1);
  const double drift = info.whole_metres ? kDriftOfMetres : kDrift;
  const LatticeSpan lon = lattice_of(g.x0 + 180.0, g.dx, info.columns, drift);
  const LatticeSpan lat = lattice_of(south + 90.0, std::abs(g.dy), info.rows, drift);
  return LatticePlacement{{lon.axis, lat.axis}, lon.first, lat.first, g.dy < 0};
}

std::optional<LatticePlacement> rebase(const LatticePlacement& b, const Lattice& a) {
  const auto east = offset_between(a.lon, b.lattice.lon);
  const auto north = offset_between(a.lat, b.lattice.lat);
  if (!east || !north) return std::nullopt;
  return LatticePlacement{a, b.i0 + *east, b.j0 + *north, b.north_up};
}

}  // namespace cairn
