#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_progress.h"
#include "builder/app/export_target.h"
#include "builder/app/pack_metadata.h"
#include "builder/app/region_argument.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/export/grid_sampler.h"
#include "builder/export/hillshade_shading.h"
#include "builder/export/picture_writer.h"
#include "cairn/remote_pack.h"

namespace cairn {
namespace {

constexpr int kMostPixels = 65536;    // along a side
constexpr int kDefaultPixels = 1024;  // along the longer side
constexpr int kBandRows = 64;         // of the picture, shaded at a time

struct HillshadeOptions {
  std::string pack;
  std::string output;
  std::string size;
  std::vector<double> region;
  double azimuth_deg = 315;
  double altitude_deg = 45;
  std::optional<double> z;
  bool grey = false;
  bool json = false;
};

struct PictureSize {
  int columns = 0;
  int rows = 0;
};

/// What is drawn, on a grid twice as fine as the picture: the average of four is smoother.
struct Plan {
  GeoBounds region;
  PictureSize size;
  int level = 0;  // the finest that the picture can show
  double degrees_a_column = 0;
  double degrees_a_row = 0;
  double degree_m = 0;  // metres on a sphere of the mean radius; for light, near enough
};

Result<PictureSize> parse_size(const std::string& text) {
  PictureSize size;
  char rest = 0;
  const int fields = std::sscanf(text.c_str(), "%dx%d%c", &size.columns, &size.rows, &rest);
  const auto good = [](int side) { return side >= 1 && side <= kMostPixels; };
  if (fields == 2 && good(size.columns) && good(size.rows)) return size;
  return usage_error(
      fmt::format("--size: expected WIDTHxHEIGHT of 1 to {} pixels, found {}", kMostPixels, text));
}

PictureSize default_size(const GeoBounds& region) {
  const double middle = (region.south + region.north) / 2 * std::numbers::pi / 180;
  const double width = region.width() * std::max(0.1, std::cos(middle)), height = region.height();
  const double scale = kDefaultPixels / std::max(width, height);
  const auto side = [scale](double degrees) {
    return std::max(1, static_cast<int>(std::lround(degrees * scale)));
  };
  return {side(width), side(height)};
}

Result<GeoBounds> baked_bounds(const PackReader& pack) {
  const Result<nlohmann::json> metadata = parse_metadata(pack);
  if (!metadata) return metadata.error();
  const auto bounds = metadata->find("bounds");
  const auto edge = [&](const char* name) {
    const bool there = bounds != metadata->end() && bounds->is_object() && bounds->contains(name) &&
                       bounds->at(name).is_number();
    return there ? bounds->at(name).get<double>() : std::nan("");
  };
  const GeoBounds found{edge("west"), edge("south"), edge("east"), edge("north")};
  if (found.west < found.east && found.south < found.north) return found;
  return bad_data(pack.path().string() + ": metadata: bounds: expected an area, found none");
}

Result<GeoBounds> wanted_region(const HillshadeOptions& options, const PackReader& pack) {
  return options.region.empty() ? baked_bounds(pack) : region_of(options.region);
}

Result<Plan> make_plan(const HillshadeOptions& options, const PackReader& pack) {
  const auto levels = pack.levels(Layer::heights);
  if (!levels) return bad_data(options.pack + ": expected height tiles, found none");
  const Result<GeoBounds> region = wanted_region(options, pack);
  if (!region) return region.error();
  Plan plan;
  plan.region = *region;
  const Ellipsoid& body = pack.header().body.shape;
  plan.degree_m = (2 * body.semi_major_m + body.semi_minor_m) / 3 * std::numbers::pi / 180;
  plan.size = default_size(*region);
  if (!options.size.empty()) {
    const Result<PictureSize> size = parse_size(options.size);
    if (!size) return size.error();
    plan.size = *size;
  }
  plan.degrees_a_column = region->width() / (2.0 * plan.size.columns);
  plan.degrees_a_row = region->height() / (2.0 * plan.size.rows);
  const double finest = std::min(plan.degrees_a_column, plan.degrees_a_row) * (pack.header().tile_size - 1);
  plan.level =
      static_cast<int>(std::clamp(std::ceil(-std::log2(finest)), static_cast<double>(levels->coarsest),
                                  static_cast<double>(levels->finest)));
  return plan;
}

/// Where the tints end: the highest and deepest places of the tiles in view, so that hills are as
/// colourful as mountains, but not so far that a plain looks like one.
ReliefStyle style_for(const PackReader& pack, const Plan& plan, const HillshadeOptions& options) {
  double highest = 400, deepest = -100;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::heights || entry.id.level > plan.level) continue;
    GeoBounds bounds = tile_bounds(entry.id);
    bounds.east = std::min(bounds.east, 180.0);
    GeoBounds turned = bounds;
    turned.west += 360;
    turned.east += 360;
    if (!bounds.touches(plan.region) && !turned.touches(plan.region)) continue;
    // A tile much larger than the view says little of it.
    if (bounds.width() > 2 * plan.region.width() && entry.id.level < plan.level) continue;
    highest = std::max(highest, entry.max_quanta * pack.header().quantum_m);
    deepest = std::min(deepest, entry.min_quanta * pack.header().quantum_m);
  }
  ReliefStyle style;
  style.highest_m = highest;
  style.deepest_m = deepest;
  style.row_spacing_m = plan.degrees_a_row * plan.degree_m;
  style.exaggeration = options.z.value_or(relief_exaggeration(2 * style.row_spacing_m));
  style.azimuth_deg = options.azimuth_deg;
  style.altitude_deg = options.altitude_deg;
  style.tinted = !options.grey;
  return style;
}

/// Shades picture rows `first` to `first + rows` and writes them. The sampler's grid is the fine one, with a
/// row and a column more on each side where the world goes on, so that slopes do not end at the picture's
/// border.
Status draw_band(GridSampler& sampler, const Plan& plan, ReliefStyle style, int first, int rows,
                 PictureWriter& picture) {
  const int columns = 2 * plan.size.columns + 2;
  HeightField field{columns, 2 * rows + 2, {}};
  field.metres.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(field.rows));
  if (const Status status = sampler.fill(2 * first, field.metres); !status) return status;
  std::vector<std::uint8_t> fine[2];
  for (auto& row : fine) row.resize(4 * static_cast<std::size_t>(columns));
  std::vector<std::uint8_t> out(4 * static_cast<std::size_t>(plan.size.columns));
  for (int r = 0; r < rows; ++r) {
    const double lat = plan.region.north - (2 * (first + r) + 1) * plan.degrees_a_row;
    style.column_spacing_m =
        plan.degrees_a_column * plan.degree_m * std::max(0.01, std::cos(lat * std::numbers::pi / 180));
    for (int half = 0; half < 2; ++half) shade_row(field, 2 * r + half + 1, style, fine[half]);
    const auto inner = [&](int half) { return std::span(fine[half]).subspan(4, 2 * out.size()); };
    halve_rows(inner(0), inner(1), out);
    if (const Status status = picture.write_row(out); !status) return status;
  }
  return {};
}

Status draw(const PackReader& pack, const Plan& plan, const HillshadeOptions& options) {
  const GeoBounds& region = plan.region;
  const GeoGrid area{plan.size.columns,         plan.size.rows,         region.west,       region.north,
                     2 * plan.degrees_a_column, 2 * plan.degrees_a_row, pack.header().body};
  auto picture = create_picture(options.output, area);
  if (!picture) return picture.error();
  const ReliefStyle style = style_for(pack, plan, options);
  const GeoGrid fine{2 * plan.size.columns + 2,
                     2 * plan.size.rows + 2,
                     region.west - 0.5 * plan.degrees_a_column,
                     region.north + 0.5 * plan.degrees_a_row,
                     plan.degrees_a_column,
                     plan.degrees_a_row};
  GridSampler sampler(pack, fine, plan.level);
  BakeProgress progress;
  const auto pixels = [&](int rows) {
    return static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(plan.size.columns);
  };
  for (int row = 0; row < plan.size.rows; row += kBandRows) {
    const int rows = std::min(kBandRows, plan.size.rows - row);
    if (const Status status = draw_band(sampler, plan, style, row, rows, **picture); !status) return status;
    progress.show({"hillshade", pixels(row + rows), pixels(plan.size.rows), 0});
  }
  return (*picture)->finish();
}

int run_hillshade(const HillshadeOptions& options) {
  if (!is_picture_name(options.output))
    return report_error(usage_error(options.output + ": expected a name that ends in .tif, .png or .jpg"));
  const Result<PackReader> pack = open_pack(options.pack);
  if (!pack) return report_error(pack.error());
  if (const Status status = pack->read_index(); !status) return report_error(status.error());
  const Result<Plan> plan = make_plan(options, *pack);
  if (!plan) return report_error(plan.error());
  if (const Status status = check_export_target(options.output, *pack); !status)
    return report_error(status.error());
  if (const Status status = draw(*pack, *plan, options); !status) return report_error(status.error());
  const GeoBounds& r = plan->region;
  if (options.json) {
    const nlohmann::ordered_json report = {
        {"output", options.output},
        {"columns", plan->size.columns},
        {"rows", plan->size.rows},
        {"level", plan->level},
        {"region", {{"west", r.west}, {"south", r.south}, {"east", r.east}, {"north", r.north}}}};
    fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}: {}x{} pixels of {} {} {} {}, from level {}\n", options.output, plan->size.columns,
               plan->size.rows, r.west, r.south, r.east, r.north, plan->level);
  }
  return 0;
}

}  // namespace

void add_hillshade(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<HillshadeOptions>();
  CLI::App* verb = app.add_subcommand("hillshade", "Draw a shaded relief as a georeferenced picture");
  verb->add_option("PACK", options->pack, "The pack, or its http:// or https:// address")->required();
  verb->add_option(
          "-o,--output", options->output,
          "FILE.tif (GeoTIFF), FILE.png or FILE.jpg (each with a world file); replaced where it exists")
      ->required();
  verb->add_option("--size", options->size,
                   "WIDTHxHEIGHT in pixels; by default 1024 along the longer side, true to the ground");
  verb->add_option("--region", options->region,
                   "WEST,SOUTH,EAST,NORTH in degrees; by default all that was baked")
      ->delimiter(',')
      ->expected(4);
  verb->add_option("--azimuth", options->azimuth_deg,
                   "where the light comes from, degrees clockwise from north")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  verb->add_option("--altitude", options->altitude_deg, "of the light above the horizon, degrees")
      ->check(CLI::Range(1.0, 90.0))
      ->capture_default_str();
  verb->add_option("--z", options->z,
                   "factor on heights, for the light only; by default more than 1 where pixels are large")
      ->check(CLI::Range(1e-3, 1e3));
  verb->add_flag("--grey", options->grey, "light and shade only, without tints by height");
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_hillshade(*options); });
}

}  // namespace cairn
