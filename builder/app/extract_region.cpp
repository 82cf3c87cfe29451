#include "builder/app/extract_region.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "builder/export/grid_sampler.h"

namespace cairn {
namespace {

constexpr double kMostPosts = 1 << 20;  // along a side
constexpr double kNearly = 1e-9;        // of a spacing

/// The finest level with a tile in the region, whatever turn the region's longitudes have.
std::optional<int> finest_in(const PackReader& pack, const GeoBounds& region) {
  std::optional<int> finest;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::heights || (finest && entry.id.level <= *finest)) continue;
    const GeoBounds bounds = tile_bounds(entry.id);
    for (const double turn : {-360.0, 0.0, 360.0}) {
      const GeoBounds turned{bounds.west + turn, bounds.south, bounds.east + turn, bounds.north};
      if (turned.west < region.east && turned.east > region.west && turned.south < region.north &&
          turned.north > region.south)
        finest = entry.id.level;
    }
  }
  return finest;
}

double spacing_of(const PackReader& pack, int level) {
  return std::ldexp(1.0, -level) / (pack.header().tile_size - 1);
}

Result<RegionPlan> plan_grid(const PackReader& pack, GeoGrid posts, double columns, double rows, int level) {
  if (!(columns >= 1 && rows >= 1))
    return usage_error("--region: expected an area with posts in it, found none between its edges");
  if (columns > kMostPosts || rows > kMostPosts)
    return usage_error(
        fmt::format("--region: expected at most {:.0f} posts along a side, found {:.0f} x {:.0f}", kMostPosts,
                    columns, rows));
  posts.columns = static_cast<int>(columns);
  posts.rows = static_cast<int>(rows);
  posts.body = pack.header().body;
  return RegionPlan{{posts, pack.header().vertical_datum, false}, level};
}

bool is_whole(double degrees) {
  return std::abs(degrees - std::round(degrees)) < kNearly;
}

}  // namespace

Result<RegionPlan> plan_samples(const PackReader& pack, const GeoBounds& region, std::optional<int> level) {
  if (!level) level = finest_in(pack, region);
  if (!level) return failed(pack.path().string() + ": expected heights in the region, the pack has none");
  const double spacing = spacing_of(pack, *level);
  const double first = std::ceil(region.west / spacing - kNearly),
               last = std::floor(region.east / spacing + kNearly);
  const double south = std::ceil(region.south / spacing - kNearly),
               north = std::floor(region.north / spacing + kNearly);
  return plan_grid(pack, {0, 0, first * spacing, north * spacing, spacing, spacing}, last - first + 1,
                   north - south + 1, *level);
}

Result<RegionPlan> plan_spacing(const PackReader& pack, const GeoBounds& region, double spacing) {
  const auto levels = pack.levels(Layer::heights);
  const auto finest = finest_in(pack, region);
  if (!levels || !finest)
    return failed(pack.path().string() + ": expected heights in the region, the pack has none");
  int level = levels->coarsest;
  while (level < *finest && spacing_of(pack, level) > spacing * (1 + kNearly)) ++level;
  return plan_grid(pack, {0, 0, region.west, region.north, spacing, spacing},
                   std::floor(region.width() / spacing + kNearly) + 1,
                   std::floor(region.height() / spacing + kNearly) + 1, level);
}

Result<RegionPlan> plan_cell(const PackReader& pack, const GeoBounds& region) {
  if (!is_whole(region.west) || !is_whole(region.south) || std::abs(region.width() - 1) > kNearly ||
      std::abs(region.height() - 1) > kNearly)
    return usage_error(fmt::format(
        ".hgt: expected one cell of 1 degree, which is all that the format has, found {:g} {:g} {:g} {:g}",
        region.west, region.south, region.east, region.north));
  const auto finest = finest_in(pack, region);
  if (!finest) return failed(pack.path().string() + ": expected heights in the cell, the pack has none");
  const int intervals = spacing_of(pack, *finest) * 2400 < 1 ? 3600 : 1200;
  return plan_grid(
      pack, {0, 0, std::round(region.west), std::round(region.north), 1.0 / intervals, 1.0 / intervals},
      intervals + 1, intervals + 1, *finest);
}

HeightRows rows_of(const PackReader& pack, const RegionPlan& plan, BakeProgress& progress) {
  struct Band {
    GridSampler sampler;
    std::vector<float> metres;
    int first = 0;
    int rows = 0;
  };
  const GeoGrid& posts = plan.grid.posts;
  auto band = std::make_shared<Band>(Band{GridSampler(pack, posts, plan.level), {}, 0, 0});
  return [band, &posts, &progress](int row, std::span<double> out) -> Status {
    const auto columns = static_cast<std::size_t>(posts.columns);
    if (row >= band->first + band->rows) {
      band->first = row;
      band->rows = std::min(GridSampler::kBandRows, posts.rows - row);
      band->metres.resize(columns * static_cast<std::size_t>(band->rows));
      if (auto status = band->sampler.fill(row, band->metres); !status) return status;
      progress.show({"extract", static_cast<std::uint64_t>(row) * columns,
                     static_cast<std::uint64_t>(posts.rows) * columns, 0});
    }
    const auto begin = band->metres.begin() + static_cast<std::ptrdiff_t>(columns) * (row - band->first);
    std::transform(begin, begin + posts.columns, out.begin(), [](float m) { return static_cast<double>(m); });
    return {};
  };
}

}  // namespace cairn
