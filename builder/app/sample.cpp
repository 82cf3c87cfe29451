#include <algorithm>
#include <fstream>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/points_csv.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Heights = std::vector<std::optional<PackSampler::Height>>;

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;
constexpr std::size_t kCachedTiles = 32;

struct SampleOptions {
  std::string pack;
  std::optional<double> lon;
  std::optional<double> lat;
  std::string points;
  std::optional<int> level;
  bool json = false;
};

Result<std::optional<PackSampler::Height>> height_at(PackSampler& sampler, LonLat place,
                                                     std::optional<int> level) {
  return level ? sampler.height_at(place, *level, *level) : sampler.height_at(place);
}

/// Answers a batch tile by tile, so that points in any order decode each tile once; the answers are in the
/// points' order.
Result<Heights> sample_batch(const PackReader& pack, PackSampler& sampler,
                             const std::vector<CsvPoint>& points, std::optional<int> level) {
  const auto range = pack.levels(Layer::heights);
  std::vector<std::pair<TileId, std::size_t>> order;
  order.reserve(points.size());
  for (const CsvPoint& point : points)
    order.emplace_back(tile_at(point.place, range ? range->finest : 0), order.size());
  std::sort(order.begin(), order.end());
  Heights heights(points.size());
  for (const auto& [tile, i] : order) {
    const auto height = height_at(sampler, points[i].place, level);
    if (!height) return height.error();
    heights[i] = *height;
  }
  return heights;
}

Json point_json(const CsvPoint& point, const std::optional<PackSampler::Height>& height) {
  return {{"lon", point.place.lon},
          {"lat", point.place.lat},
          {"height", height ? Json(height->metres) : Json()},
          {"level", height ? Json(height->level) : Json()}};
}

void print_csv(const std::vector<CsvPoint>& points, const Heights& heights) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (heights[i]) {
      fmt::print("{},{},{:.4f},{}\n", points[i].lon_text, points[i].lat_text, heights[i]->metres,
                 heights[i]->level);
    } else {
      fmt::print("{},{},,\n", points[i].lon_text, points[i].lat_text);
    }
  }
}

int sample_points(const PackReader& pack, std::istream& in, const SampleOptions& options) {
  PackSampler sampler(pack, kCachedTiles);
  PointsCsv csv(in, options.points);
  if (!options.json) fmt::print("lon,lat,height,level\n");
  const char* separator = "[\n";
  for (;;) {
    const Result<std::vector<CsvPoint>> points = csv.next(kBatchPoints);
    if (!points) return report_error(points.error());
    if (points->empty()) break;
    const Result<Heights> heights = sample_batch(pack, sampler, *points, options.level);
    if (!heights) return report_error(heights.error());
    if (!options.json) {
      print_csv(*points, *heights);
      continue;
    }
    for (std::size_t i = 0; i < points->size(); ++i) {
      fmt::print("{}{}", separator, point_json((*points)[i], (*heights)[i]).dump());
      separator = ",\n";
    }
  }
  if (options.json) fmt::print("{}]\n", *separator == '[' ? "[" : "\n");
  return 0;
}

int sample_place(const PackReader& pack, const SampleOptions& options) {
  PackSampler sampler(pack, 1);
  const CsvPoint point{{*options.lon, *options.lat}, {}, {}};
  const auto height = height_at(sampler, point.place, options.level);
  if (!height) return report_error(height.error());
  if (options.json) {
    fmt::print("{}\n", point_json(point, *height).dump());
  } else {
    fmt::print("{}\n", *height ? fmt::format("{:.4f}", (*height)->metres) : "");
  }
  return 0;
}

int run_sample(const SampleOptions& options) {
  if (options.points.empty() == !options.lat.has_value()) {
    return report_error(usage_error("sample: expected LON LAT or --points FILE.csv, and not both"));
  }
  const Result<PackReader> pack = PackReader::open(options.pack);
  if (!pack) return report_error(pack.error());
  if (options.lat) return sample_place(*pack, options);
  if (options.points == "-") return sample_points(*pack, std::cin, options);
  std::ifstream file(options.points);
  if (!file) return report_error(failed(options.points + ": cannot be opened"));
  return sample_points(*pack, file, options);
}

}  // namespace

void add_sample(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SampleOptions>();
  CLI::App* verb = app.add_subcommand("sample", "Print heights at places, in metres");
  verb->add_option("PACK", options->pack, "The pack")->required();
  CLI::Option* lon = verb->add_option("LON", options->lon, "Degrees east");
  CLI::Option* lat = verb->add_option("LAT", options->lat, "Degrees north");
  lon->needs(lat);
  verb->add_option(
      "--points", options->points,
      "Places from a CSV file with columns lon,lat (- reads stdin); prints lon,lat,height,level in "
      "the same order, the height empty where there is none");
  verb->add_option("--level", options->level, "Ask this level only, not the finest there is")
      ->check(CLI::Range(kMinLevel, kMaxLevel));
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_sample(*options); });
}

}  // namespace cairn
