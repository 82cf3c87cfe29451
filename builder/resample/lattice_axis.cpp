#include "builder/resample/lattice_axis.h"

#include <cassert>
#include <cmath>

namespace cairn {
namespace {

constexpr double kPhaseTolerance = 1e-4;

double snapped_posts_per_degree(double spacing, std::int64_t count, double most_drift) {
  const double exact = 1 / spacing;
  const double whole = std::round(exact);
  // The raster is re-placed by its first post, so only the drift along it moves posts.
  const bool near = whole > 0 && std::abs(spacing * whole - 1) * static_cast<double>(count) <= most_drift;
  return near ? whole : exact;
}

}  // namespace

LatticeSpan lattice_of(double first_degrees, double spacing_degrees, std::int64_t count, double most_drift) {
  assert(spacing_degrees > 0 && count > 0);
  LatticeSpan span;
  span.axis.posts_per_degree = snapped_posts_per_degree(spacing_degrees, count, most_drift);
  const double index = first_degrees * span.axis.posts_per_degree;
  const double halves = std::round(index * 2) / 2;
  const double snapped = std::abs(index - halves) <= kPhaseTolerance ? halves : index;
  span.first = static_cast<std::int64_t>(std::floor(snapped));
  span.axis.phase = snapped - std::floor(snapped);
  return span;
}

}  // namespace cairn
