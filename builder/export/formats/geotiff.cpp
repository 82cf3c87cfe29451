// One cloud-optimized GeoTIFF of the pack's own samples.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/export/export_folder.h"
#include "builder/export/export_format.h"
#include "builder/export/grid_sampler.h"
#include "builder/export/height_image.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/pack_patches.h"
#include "builder/raster/reader_plugin.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostPosts = 1 << 20;  // along a side
constexpr double kNearly = 1e-9;        // of a spacing

/// The samples of a level that lie in the region.
Result<GeoGrid> samples_in(const PackReader& pack, const GeoBounds& region, int level) {
  const double spacing = std::ldexp(1.0, -level) / (pack.header().tile_size - 1);
  const double west = std::ceil(region.west / spacing - kNearly),
               east = std::floor(region.east / spacing + kNearly);
  const double south = std::ceil(region.south / spacing - kNearly),
               north = std::floor(region.north / spacing + kNearly);
  const double columns = east - west + 1, rows = north - south + 1;
  if (!(columns >= 2 && rows >= 2))
    return usage_error("region: expected an area with samples in it, found none between its edges");
  if (columns > kMostPosts || rows > kMostPosts)
    return usage_error(
        fmt::format("region: expected at most {:.0f} posts a side, found {:.0f} x {:.0f}; a coarser level "
                    "has fewer",
                    kMostPosts, columns, rows));
  return GeoGrid{
      static_cast<int>(columns), static_cast<int>(rows), west * spacing, north * spacing, spacing, spacing,
      pack.header().body};
}

using CopyAsCog = void (*)(const std::filesystem::path& from, const std::filesystem::path& to, Status& out);

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  const auto levels = pack.levels(Layer::heights);
  if (!levels) return bad_data(pack.path().string() + ": expected height tiles, found none");
  const auto datum = datum_of(pack, options);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options.heights.value_or(ExportHeights::as_stored), options.geoid);
  if (!shift) return shift.error();
  if (options.levels && options.levels->coarsest != options.levels->finest)
    return usage_error(
        "levels: expected one, since a file has the samples of one level and overviews, found several");
  const PackAccuracy accuracy = accuracy_of(pack);
  const auto region = options.region ? options.region : accuracy.bounds;
  if (!region) return bad_data(pack.path().string() + ": metadata: bounds: expected an area, found none");
  const int level = options.levels ? options.levels->finest : levels->finest;
  if (level > levels->finest || level < levels->coarsest)
    return usage_error(fmt::format("level: expected {} to {}, which the pack has, found {}", levels->coarsest,
                                   levels->finest, level));
  const auto grid = samples_in(pack, *region, level);
  if (!grid) return grid.error();
  const PackPatches patches(pack, accuracy.finest_error_m);
  const double west = std::max(region->west, -180.0), east = std::min(region->east, 180.0);
  const TickRect rect{static_cast<std::int64_t>(std::ldexp(west + 180, kTickBits)),
                      static_cast<std::int64_t>(std::ldexp(region->south + 90, kTickBits)),
                      static_cast<std::int64_t>(std::ldexp(east + 180, kTickBits)),
                      static_cast<std::int64_t>(std::ldexp(region->north + 90, kTickBits))};
  const std::vector<Patch> tiles = patches.over(rect, 0, level);
  if (tiles.empty())
    return failed(pack.path().string() + ": expected heights in the region, the pack has none");
  // The raster's samples are the pack's: it is off the posts by what the pack's surface of this level is.
  double error = 0;
  for (const Patch& tile : tiles) error = std::max(error, tile.error_m);
  if (options.max_error_m && error > *options.max_error_m)
    return failed(fmt::format("level {}: expected at most {:g} m off the source posts, found {:g} m", level,
                              *options.max_error_m, error));
  const auto copy = reinterpret_cast<CopyAsCog>(load_reader_plugin("cairn-gdal", "cairn_copy_as_cog"));
  if (copy == nullptr) return failed("GDAL: expected the module cairn-gdal beside the program, found none");
  const Json identity = {{"format", "geotiff"}, {"pack", identity_of(pack)}};
  auto folder = ExportFolder::begin(options.target, identity.dump(), options.resume);
  if (!folder) return folder.error();
  const std::filesystem::path plain = folder->path() / "plain.tif", cog = folder->path() / "cog.tif";
  tbb::task_arena arena(options.threads);
  GridSampler sampler(pack, *grid, level);
  Progress now{"export", 0, static_cast<std::uint64_t>(grid->rows), 0};
  std::vector<float> band;
  int first = 0;
  const HeightRows rows = [&](int row, std::span<double> metres) -> Status {
    if (row >= first + static_cast<int>(band.size() / static_cast<std::size_t>(grid->columns))) {
      first = row;
      const int count = std::min(GridSampler::kBandRows, grid->rows - row);
      band.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(grid->columns));
      if (auto status = arena.execute([&] { return sampler.fill(row, band); }); !status) return status;
      now.done = static_cast<std::uint64_t>(row);
      if (!progress(now))
        return failed(fmt::format("export: cancelled after {} of {} rows", row, grid->rows));
    }
    const auto* from = band.data() + static_cast<std::size_t>(row - first) * metres.size();
    for (std::size_t c = 0; c < metres.size(); ++c) {
      const LonLat place{grid->west + static_cast<double>(c) * grid->column_degrees,
                         grid->north - row * grid->row_degrees};
      metres[c] = static_cast<double>(from[c]) + shift->at(place);
    }
    return {};
  };
  if (auto status = write_height_tiff(plain, {*grid, shift->datum, false}, rows); !status)
    return status.error();
  Status copied;
  copy(plain, cog, copied);
  if (!copied) return copied.error();
  std::error_code ignored;
  const std::uint64_t bytes = std::filesystem::file_size(cog, ignored);
  if (auto status = folder->finish_as_file("cog.tif"); !status) return status.error();
  ExportReport report;
  report.datum = shift->datum;
  report.levels.push_back({level, 1, bytes, 0, 0, 0, error, ""});
  report.notes.push_back(fmt::format("{} x {} samples of level {}, pixel is point; a void is -32768.",
                                     grid->columns, grid->rows, level));
  return report;
}

}  // namespace

extern const ExportFormat geotiff_exporter;
const ExportFormat geotiff_exporter{
    "geotiff", "one cloud-optimized GeoTIFF of the pack's samples at one level, with overviews", write};

}  // namespace cairn
