#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_progress.h"
#include "builder/app/export_target.h"
#include "builder/app/interrupt.h"
#include "builder/app/one_of.h"
#include "builder/app/region_argument.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/export/export_format.h"
#include "cairn/remote_pack.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct ExportArguments {
  std::string pack;
  std::string format;
  std::vector<double> region;
  std::string levels;
  std::size_t memory_mib = 1024;
  bool json = false;
  ExportOptions options;
};

Result<ExportOptions::Levels> levels_of(const std::string& text) {
  ExportOptions::Levels levels;
  char rest = 0;
  const int fields = std::sscanf(text.c_str(), "%d-%d%c", &levels.coarsest, &levels.finest, &rest);
  if (fields == 2 && levels.coarsest <= levels.finest) return levels;
  return usage_error("--levels: expected A-B, two levels, found " + text);
}

Result<ExportOptions> options_from(const ExportArguments& arguments) {
  ExportOptions options = arguments.options;
  if (!arguments.region.empty()) {
    const auto region = region_of(arguments.region);
    if (!region) return region.error();
    options.region = *region;
  }
  if (!arguments.levels.empty()) {
    const auto levels = levels_of(arguments.levels);
    if (!levels) return levels.error();
    options.levels = *levels;
  }
  if (options.threads == 0)
    options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  options.memory_bytes = arguments.memory_mib << 20;
  return options;
}

Json json_of(const ExportLevel& l, bool is_imagery) {
  Json json = {{"level", l.level}, {"tiles", l.tiles}, {"bytes", l.bytes}};
  if (is_imagery) {
    json["colour_rms"] = l.colour_rms;
  } else {
    json.update({{"vertices", l.vertices},
                 {"triangles", l.triangles},
                 {"bound_m", l.bound_m},
                 {"max_error_m", l.max_error_m}});
  }
  json["worst"] = l.worst;
  return json;
}

void print_json(const ExportArguments& arguments, const ExportReport& report) {
  Json json = {{"output", arguments.options.target.string()}, {"format", arguments.format}};
  if (!report.is_imagery) json["vertical_datum"] = to_string(report.datum);
  json["levels"] = Json::array();
  for (const ExportLevel& l : report.levels) json["levels"].push_back(json_of(l, report.is_imagery));
  json["notes"] = report.notes;
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_table(const ExportArguments& arguments, const ExportReport& report) {
  const auto mib = [](const ExportLevel& l) { return static_cast<double>(l.bytes) / 1048576; };
  const std::string output = arguments.options.target.string();
  if (report.is_imagery) {
    fmt::print("{}: {}\n{:>5} {:>9} {:>10} {:>12}  {}\n", output, arguments.format, "level", "tiles", "MiB",
               "largest rms", "in tile");
    for (const ExportLevel& l : report.levels)
      fmt::print("{:>5} {:>9} {:>10.2f} {:>12.2f}  {}\n", l.level, l.tiles, mib(l), l.colour_rms, l.worst);
    return;
  }
  fmt::print("{}: {}, heights above {}\n", output, arguments.format,
             report.datum == VerticalDatum::unknown ? "an unknown datum" : to_string(report.datum));
  fmt::print("{:>5} {:>9} {:>10} {:>11} {:>12} {:>12}  {}\n", "level", "tiles", "MiB", "triangles", "bound m",
             "largest m", "in tile");
  for (const ExportLevel& l : report.levels)
    fmt::print("{:>5} {:>9} {:>10.2f} {:>11} {:>12.3f} {:>12.3f}  {}\n", l.level, l.tiles, mib(l),
               l.triangles, l.bound_m, l.max_error_m, l.worst);
}

void print_report(const ExportArguments& arguments, const ExportReport& report) {
  if (arguments.json) return print_json(arguments, report);
  print_table(arguments, report);
  for (const std::string& note : report.notes) fmt::print("{}\n", note);
}

std::string remedy_for(const Error& error) {
  const auto says = [&](const char* text) { return error.message.find(text) != std::string::npos; };
  if (says("found the work of an interrupted export")) return "; --resume goes on with it";
  if (says("vertical datum: expected one that is known"))
    return "; --datum tells it, --heights stored leaves heights as they are";
  if (says("geoid: expected the undulations"))
    return "; --geoid names a file of them, --heights stored leaves heights as they are";
  if (says("which the memory holds")) return "; --memory allows more";
  if (says("error: expected")) return "; --max-error says it";
  return "";
}

const ExportFormat& format_of(const std::string& name) {
  const auto formats = export_formats();
  return **std::find_if(formats.begin(), formats.end(),
                        [&](const ExportFormat* f) { return f->name == name; });
}

Status export_pack(const ExportArguments& arguments) {
  const auto options = options_from(arguments);
  if (!options) return options.error();
  const auto pack = open_pack(arguments.pack);
  if (!pack) return pack.error();
  const Interrupt interrupt;
  Result<ExportReport> report = [&] {
    BakeProgress progress(ProgressUnit::parts);
    return format_of(arguments.format).write(*pack, *options, [&](const Progress& p) {
      progress.show(p);
      return !interrupt.is_asked();
    });
  }();
  if (!report) {
    Error error = report.error();
    error.message += remedy_for(error);
    if (interrupt.is_asked()) report_error(error);
    interrupt.end_program();
    return error;
  }
  print_report(arguments, *report);
  return {};
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  ExportOptions& o = arguments->options;
  CLI::App* verb =
      app.add_subcommand("export", "Write a pack, or a region of it, in another program's format");
  std::vector<std::string> formats;
  std::string summaries;
  for (const ExportFormat* format : export_formats()) {
    formats.push_back(format->name);
    summaries += (summaries.empty() ? "" : "; ") + std::string(format->name) + ": " + format->summary;
  }
  const std::map<std::string, VerticalDatum> datums{{"egm96", VerticalDatum::egm96},
                                                    {"ellipsoid", VerticalDatum::ellipsoid}};
  const std::map<std::string, ExportHeights> heights{{"ellipsoidal", ExportHeights::ellipsoidal},
                                                     {"stored", ExportHeights::as_stored}};
  verb->add_option("PACK", arguments->pack, "The pack, or its http:// or https:// address")->required();
  verb->add_option("-o,--output", o.target, "the file or folder to make")->required();
  verb->add_option("--format", arguments->format, summaries)->required()->check(CLI::IsMember(formats));
  verb->add_option("--region", arguments->region,
                   "WEST,SOUTH,EAST,NORTH in degrees: only what touches it, and the tiles above that")
      ->delimiter(',')
      ->expected(4);
  verb->add_option("--max-error", o.max_error_m,
                   "metres that no source post is off by, in tiles that have no finer ones")
      ->check(CLI::Range(1e-4, 1e5));
  verb->add_option("--levels", arguments->levels,
                   "A-B: the coarsest and the finest level of the output's tiles");
  verb->add_option("--datum", o.datum, "what the pack's heights are measured from, where it does not say")
      ->transform(one_of(datums));
  verb->add_option(
          "--geoid", o.geoid,
          "undulations of the geoid that the pack's heights are above: a raster around the Earth or a "
          ".pgm of GeographicLib (its installed egm96-5)")
      ->check(CLI::ExistingFile);
  verb->add_option(
          "--heights", o.heights,
          "ellipsoidal: above the WGS84 ellipsoid, which is what CesiumJS draws; stored: above the pack's "
          "own datum, which is what maps show")
      ->transform(one_of(heights));
  verb->add_option(
          "--posts", o.posts,
          "of r16: posts along a side of a file, such as 1009, 2017, 4033 or 8129 (Unreal), 513 to 4097 "
          "(Unity), 1024 (Terrain3D)")
      ->check(CLI::Range(2, 8193))
      ->capture_default_str();
  verb->add_option("--spacing", o.spacing_m, "of r16: metres from one post to the next; about the pack's own")
      ->check(CLI::Range(1e-3, 1e5));
  verb->add_option("--memory", arguments->memory_mib, "MiB that the program stays under")
      ->capture_default_str();
  verb->add_option("--threads", o.threads, "0 for all")->check(CLI::Range(0, 1024))->capture_default_str();
  verb->add_flag("--resume", o.resume, "go on with an interrupted export to the same output");
  verb->add_flag("--json", arguments->json, "print the report as JSON");
  o.threads = 0;
  verb->callback([arguments, &exit_code] {
    const Status status = export_pack(*arguments);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
