#include "builder/mosaic/source_order.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

namespace cairn {
namespace {

constexpr double kEqualSpacing = 1.05;

// Along a great circle, nearly.
double degrees_between(LonLat a, LonLat b) {
  const double lat = (a.lat + b.lat) / 2 * std::numbers::pi / 180;
  const double east = std::remainder(b.lon - a.lon, 360) * std::cos(lat);
  return std::hypot(east, b.lat - a.lat);
}

// In the middle of the raster.
double spacing_degrees(const RasterInfo& info) {
  const auto column = static_cast<double>(info.columns / 2), row = static_cast<double>(info.rows / 2);
  const LonLat here = info.georeference.place_of(column, row);
  return std::max(degrees_between(here, info.georeference.place_of(column + 1, row)),
                  degrees_between(here, info.georeference.place_of(column, row + 1)));
}

struct Ranked {
  std::unique_ptr<SourceGroup> group;
  double spacing = 0;
  int fineness = 0;  // equal for spacings that count as equal; the finest first
  int priority = 0;  // as the user says, of all its sources; the highest first
};

Ranked ranked(const RasterPool& pool, std::unique_ptr<SourceGroup> group) {
  Ranked rank{std::move(group)};
  const RasterInfo& first = pool.info(rank.group->sources().front());
  rank.spacing = spacing_degrees(first);
  rank.priority = first.overrides.priority.value_or(0);
  return rank;
}

}  // namespace

void sort_by_priority(const RasterPool& pool, std::vector<std::unique_ptr<SourceGroup>>& groups) {
  std::vector<Ranked> ranks;
  for (auto& group : groups) ranks.push_back(ranked(pool, std::move(group)));
  std::sort(ranks.begin(), ranks.end(),
            [](const Ranked& a, const Ranked& b) { return a.spacing < b.spacing; });
  double finest_of_class = 0;
  int fineness = 0;
  for (Ranked& rank : ranks) {
    if (rank.spacing > finest_of_class * kEqualSpacing) {
      finest_of_class = rank.spacing;
      ++fineness;
    }
    rank.fineness = fineness;
  }
  std::sort(ranks.begin(), ranks.end(), [](const Ranked& a, const Ranked& b) {
    return std::tuple(-a.priority, a.fineness, a.group->sources().front()) <
           std::tuple(-b.priority, b.fineness, b.group->sources().front());
  });
  for (std::size_t g = 0; g < groups.size(); ++g) groups[g] = std::move(ranks[g].group);
}

}  // namespace cairn
