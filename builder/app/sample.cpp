#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/datum_shift.h"
#include "builder/app/one_of.h"
#include "builder/app/points_csv.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "cairn/pack_sampler.h"
#include "cairn/remote_pack.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Heights = std::vector<std::optional<PackSampler::Height>>;

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;
constexpr std::size_t kCachedTiles = 32;
constexpr auto kReplaceBytes = Json::error_handler_t::replace;  // text of a file in any encoding

struct SampleOptions {
  std::string pack;
  std::optional<double> lon;
  std::optional<double> lat;
  std::string points;
  std::vector<std::string> columns;
  std::optional<int> level;
  DatumShift::To datum = DatumShift::To::stored;
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
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].place) order.emplace_back(tile_at(*points[i].place, range ? range->finest : 0), i);
  std::sort(order.begin(), order.end());
  Heights heights(points.size());
  for (const auto& [tile, i] : order) {
    const auto height = height_at(sampler, *points[i].place, level);
    if (!height) return height.error();
    heights[i] = *height;
  }
  return heights;
}

Json point_json(const std::optional<LonLat>& place, const std::optional<PackSampler::Height>& height) {
  return {{"lon", place ? Json(place->lon) : Json()},
          {"lat", place ? Json(place->lat) : Json()},
          {"height", height ? Json(height->metres) : Json()},
          {"level", height ? Json(height->level) : Json()}};
}

Json point_json(const CsvPoint& point, const std::optional<PackSampler::Height>& height,
                const std::vector<std::string>& other_names) {
  Json json = point_json(point.place, height);
  for (std::size_t i = 0; i < other_names.size(); ++i) json["columns"][other_names[i]] = point.others[i];
  return json;
}

/// Prints the fields as a line of a table. Blanks cannot show an empty field, so commas stand for them.
void print_fields(const std::vector<std::string>& fields, char separator) {
  const char between = separator == ' ' ? ',' : separator;
  std::string line;
  for (const std::string& field : fields) line += csv_field(field, between) + between;
  line.back() = '\n';
  fmt::print("{}", line);
}

void print_header(const PointsCsv& csv) {
  std::vector<std::string> names{"lon", "lat", "height", "level"};
  names.insert(names.end(), csv.other_names().begin(), csv.other_names().end());
  print_fields(names, csv.separator());
}

void print_rows(const PointsCsv& csv, const std::vector<CsvPoint>& points, const Heights& heights) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::string metres = heights[i] ? fmt::format("{:.4f}", heights[i]->metres) : "";
    if (csv.has_decimal_commas()) std::replace(metres.begin(), metres.end(), '.', ',');
    std::vector<std::string> fields{points[i].lon_text, points[i].lat_text, metres,
                                    heights[i] ? std::to_string(heights[i]->level) : ""};
    fields.insert(fields.end(), points[i].others.begin(), points[i].others.end());
    print_fields(fields, csv.separator());
  }
}

void shift_heights(const DatumShift& shift, const std::vector<CsvPoint>& points, Heights& heights) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (heights[i]) heights[i]->metres += shift.at(*points[i].place);
}

int sample_points(const PackReader& pack, const DatumShift& shift, std::istream& in,
                  const SampleOptions& options) {
  PackSampler sampler(pack, kCachedTiles);
  PointsCsv csv(in, options.points, options.columns);
  const char* separator = "[\n";
  for (bool first = true;; first = false) {
    const Result<std::vector<CsvPoint>> points = csv.next(kBatchPoints);
    if (!points) return report_error(points.error());
    if (first && !options.json) print_header(csv);
    if (points->empty()) break;
    Result<Heights> heights = sample_batch(pack, sampler, *points, options.level);
    if (!heights) return report_error(heights.error());
    shift_heights(shift, *points, *heights);
    if (!options.json) {
      print_rows(csv, *points, *heights);
      continue;
    }
    for (std::size_t i = 0; i < points->size(); ++i) {
      fmt::print(
          "{}{}", separator,
          point_json((*points)[i], (*heights)[i], csv.other_names()).dump(-1, ' ', false, kReplaceBytes));
      separator = ",\n";
    }
  }
  if (options.json) fmt::print("{}]\n", *separator == '[' ? "[" : "\n");
  const std::vector<std::string> complaints = csv.complaints();
  for (const std::string& complaint : complaints) report_error(bad_data(complaint));
  return complaints.empty() ? 0 : static_cast<int>(ErrorCode::bad_data);
}

int sample_place(const PackReader& pack, const DatumShift& shift, const SampleOptions& options) {
  PackSampler sampler(pack, 1);
  const LonLat place{*options.lon, *options.lat};
  auto height = height_at(sampler, place, options.level);
  if (!height) return report_error(height.error());
  if (*height) (*height)->metres += shift.at(place);
  if (options.json) {
    fmt::print("{}\n", point_json(place, *height).dump());
  } else {
    fmt::print("{}\n", *height ? fmt::format("{:.4f}", (*height)->metres) : "");
  }
  return 0;
}

int run_sample(const SampleOptions& options) {
  if (options.points.empty() == !options.lat.has_value()) {
    return report_error(usage_error("sample: expected LON LAT or --points FILE.csv, and not both"));
  }
  const Result<PackReader> pack = open_pack(options.pack);
  if (!pack) return report_error(pack.error());
  const Result<DatumShift> shift = DatumShift::open(*pack, options.datum);
  if (!shift) return report_error(shift.error());
  if (options.lat) return sample_place(*pack, *shift, options);
  if (options.points == "-") return sample_points(*pack, *shift, std::cin, options);
  std::ifstream file(options.points);
  if (!file) return report_error(failed(options.points + ": cannot be opened"));
  return sample_points(*pack, *shift, file, options);
}

}  // namespace

void add_sample(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SampleOptions>();
  CLI::App* verb = app.add_subcommand("sample", "Print heights at places, in metres");
  verb->add_option("PACK", options->pack, "The pack, or its http:// or https:// address")->required();
  CLI::Option* lon = verb->add_option("LON", options->lon, "Degrees east");
  CLI::Option* lat = verb->add_option("LAT", options->lat, "Degrees north");
  lon->needs(lat);
  verb->add_option(
      "--points", options->points,
      "Places from a table with columns lon,lat or x,y, separated by commas, semicolons, tabs or blanks (- "
      "reads stdin); prints lon,lat,height,level and the other columns in the order of the lines, the height "
      "empty where there is none");
  verb->add_option("--columns", options->columns, "LON,LAT: names of the columns that hold the places")
      ->delimiter(',')
      ->expected(2);
  verb->add_option("--level", options->level, "Ask this level only, not the finest there is")
      ->check(CLI::Range(kMinLevel, kMaxLevel));
  const std::map<std::string, DatumShift::To> datums{{"ellipsoid", DatumShift::To::ellipsoid},
                                                     {"orthometric", DatumShift::To::orthometric}};
  verb->add_option(
          "--datum", options->datum,
          "What heights are printed above: the ellipsoid, or the geoid EGM96 (orthometric); by default "
          "what the pack's are above")
      ->transform(one_of(datums));
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_sample(*options); });
}

}  // namespace cairn
