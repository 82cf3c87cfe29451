// Heightmaps of game engines: raw 16-bit posts on a square metric grid, with what the files themselves cannot
// say beside them.
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/bake/pipeline.h"
#include "builder/export/export_folder.h"
#include "builder/export/export_format.h"
#include "builder/export/geodesy.h"
#include "builder/export/grid_error.h"
#include "builder/export/local_plane.h"
#include "builder/export/pack_accuracy.h"
#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostTiles = 64;  // along a side
constexpr double kLargest = 65535;
constexpr std::size_t kSamplerTiles = 16;

struct Heightmap {
  int posts = 0;
  double spacing_m = 0;
  int across = 0, down = 0;  // files
  double west_m = 0, north_m = 0;
  double lowest_m = 0, highest_m = 0;
  int level = 0;

  double step_m() const { return (highest_m - lowest_m) / kLargest; }
};

struct MadeFile {
  std::vector<std::byte> bytes;
  double max_error_m = 0;
  bool has_voids = false;
};

class HeightmapExport {
 public:
  HeightmapExport(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack),
        options_(options),
        progress_(progress),
        accuracy_(accuracy_of(pack)),
        patches_(pack, accuracy_.finest_error_m) {}

  Result<ExportReport> run();

 private:
  Status plan(const VerticalShift& shift);
  GeoBounds bounds_of(int x, int y) const;
  Result<MadeFile> make(MetreTiles& tiles, const VerticalShift& shift, int x, int y) const;
  std::string name(int x, int y) const {
    return fmt::format("{}_x{}_y{}.r16", pack_.path().stem().string(), x, y);
  }
  Json sidecar(const ExportReport& report) const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  PackPatches patches_;
  GeoBounds region_;
  std::optional<LocalPlane> plane_;
  Heightmap map_;
  bool has_voids_ = false;
};

Status HeightmapExport::plan(const VerticalShift& shift) {
  if (options_.region) {
    region_ = *options_.region;
  } else if (accuracy_.bounds) {
    region_ = *accuracy_.bounds;
  } else {
    return bad_data(pack_.path().string() + ": metadata: bounds: expected an area, found none");
  }
  const LonLat centre{(region_.west + region_.east) / 2, (region_.south + region_.north) / 2};
  plane_.emplace(centre, pack_.header().body.shape);
  const auto rim = rim_on_plane(*plane_, region_);
  if (!rim) return rim.error();
  const auto& [west, south, east, north] = *rim;
  const double own = degree_lengths(centre.lat, pack_.header().body.shape).lat_m *
                     std::ldexp(1.0, -patches_.finest()) / (pack_.header().tile_size - 1);
  const double unit = std::pow(10, std::floor(std::log10(own)) - 1);
  map_.spacing_m = options_.spacing_m.value_or(std::floor(own / unit) * unit);
  map_.posts = options_.posts;
  const double side = (map_.posts - 1) * map_.spacing_m;
  const auto files = [side](double metres) { return std::max(1.0, std::ceil(metres / side - 1e-9)); };
  if (files(east - west) > kMostTiles || files(north - south) > kMostTiles)
    return usage_error(
        fmt::format("heightmap: expected at most {} files a side, found {} x {} of {} posts, {:g} m apart",
                    kMostTiles, files(east - west), files(north - south), map_.posts, map_.spacing_m));
  map_.across = static_cast<int>(files(east - west));
  map_.down = static_cast<int>(files(north - south));
  // What the files cover beyond the region lies on all sides alike.
  map_.west_m = (west + east - map_.across * side) / 2;
  map_.north_m = (south + north + map_.down * side) / 2;
  map_.level = patches_.coarsest();
  while (map_.level < patches_.finest() && degree_lengths(centre.lat, pack_.header().body.shape).lat_m *
                                                   std::ldexp(1.0, -map_.level) /
                                                   (pack_.header().tile_size - 1) >
                                               map_.spacing_m)
    ++map_.level;
  bool any = false;
  for (int y = 0; y < map_.down; ++y) {
    for (int x = 0; x < map_.across; ++x) {
      const GeoBounds b = bounds_of(x, y);
      if (!(b.west >= -180 && b.east <= 180 && b.south >= -90 && b.north <= 90))
        return usage_error(
            "region: expected one that keeps clear of the antimeridian and the poles, found another");
      const TickRect rect = ticks_around(b);
      if (!patches_.has_tile(rect, patches_.coarsest())) continue;
      // Finer tiles may rise above the samples of coarse ones.
      const PackPatches::Range range = patches_.range_over(rect, map_.level);
      map_.lowest_m = any ? std::min(map_.lowest_m, range.lowest_m) : range.lowest_m;
      map_.highest_m = any ? std::max(map_.highest_m, range.highest_m) : range.highest_m;
      any = true;
    }
  }
  if (!any) return failed(pack_.path().string() + ": expected heights in the region, the pack has none");
  if (shift.metres) {
    // Undulations within a region differ by less than 7e-4 of its width, see choose_height_steps().
    const double spread = 7e-4 * std::hypot(map_.across * side, map_.down * side);
    map_.lowest_m += shift.metres(centre) - spread;
    map_.highest_m += shift.metres(centre) + spread;
  }
  map_.highest_m = std::max(map_.highest_m, map_.lowest_m + 1);
  return {};
}

GeoBounds HeightmapExport::bounds_of(int x, int y) const {
  const double side = (map_.posts - 1) * map_.spacing_m;
  GeoBounds b{1e9, 1e9, -1e9, -1e9};
  constexpr int kPieces = 8;
  for (int i = 0; i <= kPieces; ++i) {
    for (int j = 0; j <= kPieces; ++j) {
      if (i % kPieces != 0 && j % kPieces != 0) continue;
      const LonLat p = plane_->to_place({map_.west_m + (x + static_cast<double>(i) / kPieces) * side,
                                         map_.north_m - (y + static_cast<double>(j) / kPieces) * side});
      // The plane's place may be a turn away from the region's longitudes.
      const double lon = p.lon + 360 * std::round((region_.west + region_.width() / 2 - p.lon) / 360);
      b = {std::min(b.west, lon), std::min(b.south, p.lat), std::max(b.east, lon), std::max(b.north, p.lat)};
    }
  }
  return b;
}

Result<MadeFile> HeightmapExport::make(MetreTiles& tiles, const VerticalShift& shift, int x, int y) const {
  MadeFile made;
  DecodedGrid grid{map_.posts, map_.posts, {}};
  const auto posts = static_cast<std::size_t>(map_.posts) * static_cast<std::size_t>(map_.posts);
  grid.metres.reserve(posts);
  made.bytes.reserve(posts * sizeof(std::uint16_t));
  PackSampler sampler(pack_, kSamplerTiles);
  const double step = map_.step_m();
  const double west = map_.west_m + x * (map_.posts - 1) * map_.spacing_m;
  const double north = map_.north_m - y * (map_.posts - 1) * map_.spacing_m;
  for (int r = 0; r < map_.posts; ++r) {
    for (int c = 0; c < map_.posts; ++c) {
      // Counted from the whole grid's corner, so that files have equal posts on common rows.
      const LonLat place = plane_->to_place({map_.west_m + (x * (map_.posts - 1) + c) * map_.spacing_m,
                                             map_.north_m - (y * (map_.posts - 1) + r) * map_.spacing_m});
      const auto height = sampler.height_at(place, map_.level);
      if (!height) return height.error();
      made.has_voids = made.has_voids || !*height;
      const double metres = *height ? (*height)->metres + shift.at(place) : map_.lowest_m;
      const auto value =
          static_cast<std::uint16_t>(std::clamp(std::round((metres - map_.lowest_m) / step), 0.0, kLargest));
      made.bytes.push_back(static_cast<std::byte>(value & 0xFF));
      made.bytes.push_back(static_cast<std::byte>(value >> 8));
      grid.metres.push_back(map_.lowest_m + value * step);
    }
  }
  const auto error =
      grid_error(patches_, tiles, shift, ticks_around(bounds_of(x, y)), kMaxLevel, grid, [&](LonLat p) {
        const PlanePoint at = plane_->to_plane(p);
        return GridPosition{(at.east_m - west) / map_.spacing_m, (north - at.north_m) / map_.spacing_m};
      });
  if (!error) return error.error();
  made.max_error_m = *error;
  return made;
}

Json HeightmapExport::sidecar(const ExportReport& report) const {
  const double range = map_.highest_m - map_.lowest_m;
  const LonLat centre{(region_.west + region_.east) / 2, (region_.south + region_.north) / 2};
  return {
      {"cairn", CAIRN_VERSION},
      {"format", "r16: unsigned 16 bits, little-endian, rows from north to south"},
      {"files",
       fmt::format("{}_xCOLUMN_yROW.r16, columns from the west, rows from the north; neighbours share one "
                   "row or column of posts",
                   pack_.path().stem().string())},
      {"columns_of_files", map_.across},
      {"rows_of_files", map_.down},
      {"posts_a_side", map_.posts},
      {"metres_a_post", map_.spacing_m},
      {"lowest_m", map_.lowest_m},
      {"highest_m", map_.highest_m},
      {"metres_a_step", map_.step_m()},
      {"vertical_datum", to_string(report.datum)},
      {"centre", {{"lon", centre.lon}, {"lat", centre.lat}}},
      {"first_post_m", {{"east", map_.west_m}, {"north", map_.north_m}}},
      {"projection", plane_->description()},
      {"max_error_m", report.levels.front().max_error_m},
      {"void_posts", has_voids_ ? "stand at lowest_m" : "none"},
      {"unreal",
       {{"scale_xy", map_.spacing_m * 100},
        {"scale_z", range * 100 / 512},
        {"location_z_cm", (map_.lowest_m + map_.highest_m) / 2 * 100}}},
      {"unity",
       {{"terrain_width_m", (map_.posts - 1) * map_.spacing_m},
        {"terrain_height_m", range},
        {"byte_order", "Windows"},
        {"flip_vertically", true}}},
      {"terrain3d",
       {{"import_scale", range}, {"import_offset", map_.lowest_m}, {"vertex_spacing", map_.spacing_m}}}};
}

Result<ExportReport> HeightmapExport::run() {
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::as_stored), options_.geoid);
  if (!shift) return shift.error();
  if (options_.levels)
    return usage_error(
        "levels: expected none, since a heightmap's posts are as far apart as its spacing says, found some");
  // A file's posts as numbers and as bytes, while it is made.
  const std::size_t file_bytes = static_cast<std::size_t>(options_.posts) *
                                 static_cast<std::size_t>(options_.posts) *
                                 (sizeof(double) + 2 * sizeof(std::uint16_t));
  constexpr std::size_t kProgramBytes = std::size_t{128} << 20;
  if (options_.memory_bytes < kProgramBytes + file_bytes)
    return usage_error(fmt::format("memory: expected at least {} MiB for files of {}² posts, found {}",
                                   ((kProgramBytes + file_bytes) >> 20) + 1, options_.posts,
                                   options_.memory_bytes >> 20));
  const std::size_t in_flight = std::min<std::size_t>(static_cast<std::size_t>(options_.threads),
                                                      (options_.memory_bytes - kProgramBytes) / file_bytes);
  if (auto status = plan(*shift); !status) return status.error();
  const Json identity = {{"format", "r16"},
                         {"pack", identity_of(pack_)},
                         {"datum", to_string(*datum)},
                         {"posts", map_.posts},
                         {"spacing_m", map_.spacing_m},
                         {"west", region_.west},
                         {"south", region_.south},
                         {"east", region_.east},
                         {"north", region_.north},
                         {"ellipsoidal", options_.heights == ExportHeights::ellipsoidal},
                         {"geoid", options_.geoid.string()}};
  auto folder = ExportFolder::begin(
      options_.target, identity.dump(-1, ' ', false, Json::error_handler_t::replace), options_.resume);
  if (!folder) return folder.error();
  ExportReport report;
  report.datum = shift->datum;
  report.levels.push_back({});
  ExportLevel& all = report.levels.front();
  all.level = map_.level;
  const auto count = [&](const Json& line) {
    ++all.tiles;
    all.bytes += static_cast<std::uint64_t>(map_.posts) * static_cast<std::uint64_t>(map_.posts) * 2;
    has_voids_ = has_voids_ || line.at("voids").get<bool>();
    if (const double error = line.at("max_error_m"); error > all.max_error_m || all.worst.empty()) {
      all.max_error_m = error;
      all.worst = line.at("file").get<std::string>();
    }
  };
  for (const std::string& text : folder->done()) count(Json::parse(text));
  MetreTiles tiles(pack_, 32);
  const auto files = static_cast<std::size_t>(map_.across * map_.down);
  Progress now{"export", 0, files, 0};
  tbb::task_arena arena(options_.threads);
  const Status made = arena.execute([&] {
    return run_in_order<MadeFile>(
        folder->done().size(), files, in_flight,
        [&](std::size_t i) {
          return make(tiles, *shift, static_cast<int>(i) % map_.across, static_cast<int>(i) / map_.across);
        },
        [&](std::size_t i, MadeFile&& file) -> Status {
          const std::string own = name(static_cast<int>(i) % map_.across, static_cast<int>(i) / map_.across);
          if (auto status = folder->write(own, file.bytes); !status) return status;
          const Json line = {{"file", own}, {"max_error_m", file.max_error_m}, {"voids", file.has_voids}};
          count(line);
          if (auto status = folder->append(line.dump(-1, ' ', false, Json::error_handler_t::replace));
              !status)
            return status;
          now.done = i + 1;
          now.bytes_written = all.bytes;
          return progress_(now)
                     ? Status()
                     : Status(failed(fmt::format("export: cancelled after {} of {} files", i + 1, files)));
        });
  });
  if (!made) return made.error();
  if (options_.max_error_m && all.max_error_m > *options_.max_error_m)
    return failed(fmt::format("heightmap: expected at most {:g} m off the source posts, found {:g} m in {}",
                              *options_.max_error_m, all.max_error_m, all.worst));
  const std::string text = sidecar(report).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  if (auto status = folder->write("heightmap.json", text); !status) return status.error();
  if (auto status = folder->finish(); !status) return status.error();
  report.notes.push_back(fmt::format(
      "{} x {} files of {}² posts, {:g} m apart; heights {:g} to {:g} m in steps of {:.4g} m. heightmap.json "
      "says what "
      "the engines ask for.",
      map_.across, map_.down, map_.posts, map_.spacing_m, map_.lowest_m, map_.highest_m, map_.step_m()));
  if (has_voids_) report.notes.push_back("Posts without height stand at the lowest one.");
  return report;
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  if (!pack.levels(Layer::heights))
    return bad_data(pack.path().string() + ": expected height tiles, found none");
  return HeightmapExport(pack, options, progress).run();
}

}  // namespace

extern const ExportFormat r16_exporter;
const ExportFormat r16_exporter{
    "r16", "a folder of raw 16-bit heightmaps on a metric grid, for Unreal, Unity and Godot's Terrain3D",
    write};

}  // namespace cairn
