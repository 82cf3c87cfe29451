#include "builder/export/region_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace cairn {
namespace {

/// Between samples so far apart, undulations are off a bilinear surface by at most so much; the square of the
/// distance counts.
constexpr double kNodeTicks = 1 << (kTickBits - 5);
constexpr double kNodeError_m = 0.005;

TickRect widened_to_samples(const TickRect& region, std::int64_t step) {
  const auto down = [step](std::int64_t at) { return at / step * step; };
  const auto up = [step](std::int64_t at) { return (at + step - 1) / step * step; };
  return intersection({down(region.west), down(region.south), up(region.east), up(region.north)},
                      {0, 0, kTicksAround, kTicksPoleToPole});
}

/// Writes one patch's surface at all samples that it covers. Where a sample has another height already, the
/// finer tile's counts, and the difference goes into `apart`.
void fill_patch(RegionRaster& raster, const Patch& patch, const MetreTile& tile, double& apart) {
  const TickRect area = intersection(patch.area, raster.rect);
  const auto first = [&](std::int64_t at, std::int64_t origin) {
    return (at - origin + raster.step - 1) / raster.step;
  };
  for (std::int64_t r = first(area.south, raster.rect.south);
       raster.rect.south + r * raster.step <= area.north; ++r) {
    for (std::int64_t c = first(area.west, raster.rect.west); raster.rect.west + c * raster.step <= area.east;
         ++c) {
      const double metres =
          tile.height_at(raster.rect.west + c * raster.step, raster.rect.south + r * raster.step);
      if (std::isnan(metres)) continue;
      const std::size_t i = raster.samples.index(static_cast<int>(c), static_cast<int>(r));
      float& sample = raster.samples.metres[i];
      if (raster.samples.voids[i] == 0) {
        apart = std::max(apart, std::abs(static_cast<double>(sample) - metres));
        continue;
      }
      sample = static_cast<float>(metres);
      raster.samples.voids[i] = 0;
    }
  }
}

Status shift_samples(RegionRaster& raster, const VerticalShift& shift, const std::function<Status()>& go_on) {
  HeightSamples& grid = raster.samples;
  raster.lowest_m = std::numeric_limits<double>::infinity();
  raster.highest_m = -raster.lowest_m;
  for (int r = 0; r < grid.rows; ++r) {
    if (auto status = go_on(); !status) return status;
    for (int c = 0; c < grid.columns; ++c) {
      const std::size_t i = grid.index(c, r);
      if (grid.voids[i] != 0) {
        raster.has_voids = true;
        continue;
      }
      float& sample = grid.metres[i];
      if (shift.metres)
        sample = static_cast<float>(static_cast<double>(sample) +
                                    shift.metres(raster.place(static_cast<double>(c * kUnitsOfStep),
                                                              static_cast<double>(r * kUnitsOfStep))));
      const auto metres = static_cast<double>(sample);
      raster.lowest_m = std::min(raster.lowest_m, metres);
      raster.highest_m = std::max(raster.highest_m, metres);
    }
  }
  return {};
}

}  // namespace

LonLat RegionRaster::place(double column, double row) const {
  const LonLat origin = place_of(rect.west, rect.south);
  const double unit = std::ldexp(static_cast<double>(step), -kTickBits) / kUnitsOfStep;
  return {origin.lon + column * unit, origin.lat + row * unit};
}

Result<RegionRaster> region_raster(const PackReader& pack, const PackPatches& patches, MetreTiles& tiles,
                                   const VerticalShift& shift, const TickRect& region, double error_m,
                                   std::size_t most_samples, const std::function<Status()>& go_on) {
  std::vector<Patch> parts = patches.over_with_rims(region, error_m);
  const std::string no_heights = pack.path().string() + ": expected heights in the region, the pack has none";
  if (parts.empty()) return failed(no_heights);
  // Finer tiles first: their samples count where a coarser one has the place too.
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Patch& a, const Patch& b) { return a.entry.id.level > b.entry.id.level; });
  RegionRaster raster;
  raster.level = parts.front().entry.id.level;
  raster.step = tile_ticks(raster.level) / (pack.header().tile_size - 1);
  raster.rect = widened_to_samples(region, raster.step);
  const std::int64_t columns = raster.rect.width() / raster.step + 1,
                     rows = raster.rect.height() / raster.step + 1;
  if (static_cast<double>(columns) * static_cast<double>(rows) > static_cast<double>(most_samples))
    return usage_error(fmt::format(
        "region: expected at most {} samples, which the memory holds, found {} x {}; a smaller region or a "
        "larger error needs fewer",
        most_samples, columns, rows));
  HeightSamples& grid = raster.samples;
  grid.step = kUnitsOfStep;
  grid.columns = static_cast<int>(columns);
  grid.rows = static_cast<int>(rows);
  grid.metres.assign(static_cast<std::size_t>(columns * rows), kVoidHeight);
  grid.voids.assign(grid.metres.size(), 1);
  double apart = 0;
  for (const Patch& part : parts) {
    if (auto status = go_on(); !status) return status.error();
    const auto tile = tiles.read(part.entry);
    if (!tile) return tile.error();
    fill_patch(raster, part, **tile, apart);
    grid.error_m = std::max(grid.error_m, part.error_m);
  }
  if (auto status = shift_samples(raster, shift, go_on); !status) return status.error();
  if (!(raster.lowest_m <= raster.highest_m)) return failed(no_heights);
  const double shift_error =
      shift.metres ? kNodeError_m * std::max(1.0, std::pow(static_cast<double>(raster.step) / kNodeTicks, 2))
                   : 0;
  grid.error_m += apart + shift_error;
  return raster;
}

}  // namespace cairn
