#include <algorithm>
#include <charconv>
#include <fstream>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "builder/app/bake_progress.h"
#include "builder/app/bake_report.h"
#include "builder/app/interrupt.h"
#include "builder/app/one_of.h"
#include "builder/app/report_error.h"
#include "builder/app/source_options.h"
#include "builder/app/verbs.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/output_check.h"
#include "builder/raster/expand_inputs.h"
#include "builder/raster/gdal_name.h"
#include "builder/raster/raster_source.h"
#include "builder/raster/source_overrides.h"
#include "cairn/bake_estimate.h"
#include "cairn/build.h"

namespace cairn {
namespace {

struct BakeArguments {
  std::vector<std::string> inputs;
  BuildOptions options;
  std::vector<std::string> images;
  std::vector<double> region;
  SourceArguments sources;
  std::vector<double> image_bounds;
  std::string level = "auto";
  std::string report;
  std::string geoid;
  std::size_t memory_mib = 1024;
  InputSearch search;
  bool dry_run = false;
  bool json = false;
};

Status use_bounds(const char* option, const std::vector<double>& numbers, std::optional<GeoBounds>& out) {
  if (numbers.empty()) return {};
  const GeoBounds bounds{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (!(bounds.west < bounds.east && bounds.south < bounds.north && bounds.south >= -90 &&
        bounds.north <= 90 && bounds.west >= -360 && bounds.east <= 360)) {
    return usage_error(
        fmt::format("{}: expected W<E and S<N in degrees, found {}", option, fmt::join(numbers, ",")));
  }
  out = bounds;
  return {};
}

Status use_level(const std::string& text, BuildOptions& options) {
  if (text == "auto") return {};
  int level = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), level);
  if (error != std::errc() || end != text.data() + text.size() || level < kMinLevel || level > kMaxLevel) {
    return usage_error(fmt::format("--level: expected auto or {}…{}, found {}", kMinLevel, kMaxLevel, text));
  }
  options.mosaic.level = level;
  return {};
}

Status use_memory(std::size_t mebibytes, BuildOptions& options) {
  const int threads = options.session.threads > 0 ? options.session.threads
                                                  : static_cast<int>(std::thread::hardware_concurrency());
  const std::size_t least =
      (least_memory(threads, options.grid.tile_size, !options.imagery.inputs.empty()) >> 20) + 1;
  options.session.memory_bytes = mebibytes << 20;
  if (mebibytes >= least) return {};
  return usage_error(
      fmt::format("--memory: expected {} MiB or more for {} threads, found {}", least, threads, mebibytes));
}

Status find_inputs(const std::vector<std::string>& arguments, const InputSearch& search,
                   std::vector<std::filesystem::path>& out) {
  auto found = expand_inputs(arguments, search);
  if (!found) return found.error();
  for (const auto& file : found->without_raster)
    fmt::print(stderr, "cairn: warning: {}: passed over, since no raster is in it\n", file.string());
  out = std::move(found->files);
  return {};
}

/// A pattern of --sources that no DEM matches is a slip of the pen.
Status check_rules(const MosaicOptions& mosaic) {
  for (const SourceRule& rule : mosaic.source_rules) {
    const auto matches = [&](const std::filesystem::path& dem) { return matches_glob(dem, rule.glob); };
    if (rule.glob == "*" || std::any_of(mosaic.inputs.begin(), mosaic.inputs.end(), matches)) continue;
    return usage_error(fmt::format("--sources: expected patterns that DEMs match, found {}", rule.glob));
  }
  return {};
}

Result<BuildOptions> options_from(const BakeArguments& arguments) {
  BuildOptions options = arguments.options;
  if (auto status = use_bounds("--region", arguments.region, options.grid.region); !status)
    return status.error();
  if (auto status = use_bounds("--bounds", arguments.image_bounds, options.imagery.bounds); !status)
    return status.error();
  if (auto status = use_level(arguments.level, options); !status) return status.error();
  if (!arguments.geoid.empty()) options.mosaic.geoid = arguments.geoid;
  if (arguments.inputs.empty() && arguments.images.empty())
    return usage_error("bake: expected DEMs, or images after --imagery, found neither");
  if (auto status = find_inputs(arguments.inputs, arguments.search, options.mosaic.inputs); !status)
    return status.error();
  auto dems = chosen_files(std::move(options.mosaic.inputs), arguments.sources);
  if (!dems) return dems.error();
  options.mosaic.inputs = std::move(*dems);
  auto rules = source_rules(arguments.sources);
  if (!rules) return rules.error();
  options.mosaic.source_rules = std::move(*rules);
  options.imagery.source_rules = image_rules(arguments.sources);
  if (auto status = check_rules(options.mosaic); !status) return status.error();
  if (auto status = find_inputs(arguments.images, arguments.search, options.imagery.inputs); !status)
    return status.error();
  if (auto status = use_memory(arguments.memory_mib, options); !status) return status.error();
  return options;
}

/// The report is written last, and must then neither be refused nor take the place of something else.
Status check_report(const std::string& report, const BuildOptions& options) {
  if (report.empty()) return {};
  std::vector<std::filesystem::path> others = options.mosaic.inputs;
  others.insert(others.end(), options.imagery.inputs.begin(), options.imagery.inputs.end());
  for (auto& other : others) other = file_of_gdal_name(other).value_or(other);
  if (options.mosaic.geoid) others.push_back(*options.mosaic.geoid);
  for (const char* suffix : {"", ".part", ".journal"}) {
    others.push_back(std::filesystem::path(options.session.target).concat(suffix));
    if (std::filesystem::path(report).lexically_normal() == others.back().lexically_normal())
      return usage_error(report + ": report: expected a name of its own, found the target's");
  }
  if (auto status = check_is_no_input(report, others); !status) return status;
  if (auto status = check_can_be_file(report); !status) return status;
  std::error_code ignored;
  if (std::filesystem::file_size(report, ignored) == 0) return {};
  std::ifstream there(report);
  char first = 0;
  if (!there || !(there >> first) || first == '{') return {};
  return usage_error(report + ": report: expected no such file or a report to replace, found another file");
}

std::string words_for(Remedy remedy, const BuildOptions& options) {
  switch (remedy) {
    case Remedy::replace_target:
      return "--force replaces it";
    case Remedy::accept_error:
      return "--allow-error bakes all the same";
    case Remedy::tell_body:
      return "--body NAME,a,b says which";
    case Remedy::tell_latitude:
      return "--latitude planetographic or planetocentric says it";
    case Remedy::resume:
      return fmt::format("what is baked stays in {}.part, and --resume goes on from there",
                         options.session.target.string());
    case Remedy::discard_work:
      return "--force discards it";
  }
  return "";
}

/// Adds what can be done about an error in the words of the command line.
Error with_remedies(Error error, const BuildOptions& options) {
  for (const Remedy remedy : remedies_for(error, options)) error.message += "; " + words_for(remedy, options);
  return error;
}

Result<BuildReport> build_with_progress(const BuildOptions& options, const Interrupt& interrupt) {
  BakeProgress progress;
  return build(options, [&](const Progress& p) {
    progress.show(p);
    return !interrupt.is_asked();
  });
}

Status bake(const BakeArguments& arguments) {
  const auto options = options_from(arguments);
  if (!options) return options.error();
  if (auto status = check_report(arguments.report, *options); !status) return status;
  if (arguments.dry_run) {
    const auto dry = dry_run(*options);
    if (!dry) return dry.error();
    print_dry_run(*dry, arguments.json);
    return {};
  }
  const Interrupt interrupt;
  const auto report = build_with_progress(*options, interrupt);
  if (!report) {
    const Error error = with_remedies(report.error(), *options);
    if (interrupt.is_asked()) report_error(error);
    interrupt.end_program();
    return error;
  }
  if (!report->warning.empty()) fmt::print(stderr, "cairn: warning: {}\n", report->warning);
  return print_bake_report(*report, *options, arguments.report, arguments.json);
}

void add_accuracy_options(CLI::App& verb, BakeArguments& arguments) {
  BuildOptions& o = arguments.options;
  const std::map<std::string, ResampleMethod> methods{{"nearest", ResampleMethod::nearest},
                                                      {"bilinear", ResampleMethod::bilinear},
                                                      {"cubic", ResampleMethod::cubic},
                                                      {"exact", ResampleMethod::exact},
                                                      {"smooth", ResampleMethod::smooth}};
  verb.add_option("--max-error", o.mosaic.max_error_m,
                  "error bound: metres that no post is off by (0.5 for whole metres, else 0.05)")
      ->check(CLI::Range(1e-4, 1e4));
  verb.add_option("--quantum", o.heights.quantum_m, "step in which heights are stored, metres")
      ->check(CLI::Range(1e-5, 1e3));
  verb.add_flag("--allow-error", o.heights.allow_error, "an exceeded error bound is a warning");
  verb.add_option("--resampling", o.mosaic.resampling,
                  "smooth: the surface is smooth and within the error bound at every post; exact: it passes "
                  "through the posts; cubic, bilinear, nearest: the posts are not kept")
      ->transform(one_of(methods))
      ->default_str("smooth");
  verb.add_flag_callback(
      "--exact", [&o] { o.mosaic.resampling = ResampleMethod::exact; }, "as --resampling exact");
}

void add_datum_options(CLI::App& verb, BakeArguments& arguments) {
  BuildOptions& o = arguments.options;
  const std::map<std::string, VoidMode> voids{{"fill", VoidMode::fill}, {"keep", VoidMode::keep}};
  const std::map<std::string, VerticalDatum> datums{{"unknown", VerticalDatum::unknown},
                                                    {"egm96", VerticalDatum::egm96},
                                                    {"ellipsoid", VerticalDatum::ellipsoid}};
  verb.add_option("--void", o.heights.voids, "fill voids smoothly, or keep them as holes")
      ->transform(one_of(voids))
      ->default_str("fill");
  verb.add_option("--datum", o.mosaic.datum,
                  "what the sources' heights are measured from: egm96, ellipsoid or unknown; by default what "
                  "they say, which then has to be one datum")
      ->transform(one_of(datums));
  verb.add_option("--fade", o.mosaic.fade_posts,
                  "posts of the source beneath over which the difference of a finer one fades beyond its rim")
      ->check(CLI::Range(0.0, 1e4))
      ->capture_default_str();
  verb.add_option("--geoid", arguments.geoid,
                  "raster of geoid undulations to add, so that heights are ellipsoidal")
      ->check(CLI::ExistingFile);
}

void add_imagery_options(CLI::App& verb, BakeArguments& arguments) {
  ImageryOptions& o = arguments.options.imagery;
  const std::map<std::string, TextureFormat> formats{
      {"bc1", TextureFormat::bc1}, {"bc3", TextureFormat::bc3}, {"bc7", TextureFormat::bc7}};
  const std::map<std::string, TextureQuality> qualities{
      {"fast", TextureQuality::fast}, {"normal", TextureQuality::normal}, {"best", TextureQuality::best}};
  verb.add_option("--imagery", arguments.images,
                  "image files, folders, glob patterns or @LIST; finer ones lie on top, then earlier ones");
  verb.add_option("--texture-format", o.format, "bc1 (bc3 where a tile is not opaque), bc3 or bc7")
      ->transform(one_of(formats))
      ->default_str("bc1");
  verb.add_option("--texture-quality", o.quality, "fast, normal or best")
      ->transform(one_of(qualities))
      ->default_str("normal");
  verb.add_option("--bounds", arguments.image_bounds,
                  "W,S,E,N in degrees: where images lie that do not say it themselves")
      ->delimiter(',')
      ->expected(4);
  verb.add_option("--feather", o.feather_pixels, "pixels over which an image's rim fades into those beneath")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
}

void add_work_options(CLI::App& verb, BakeArguments& arguments) {
  BuildOptions& o = arguments.options;
  verb.add_option("--memory", arguments.memory_mib, "MiB that the program stays under")
      ->capture_default_str();
  verb.add_option("--threads", o.session.threads, "0 for all")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  verb.add_flag("--resume", o.session.resume, "go on with an interrupted bake to the same target");
  verb.add_flag("--force", o.session.force, "replace the target");
  verb.add_flag("--dry-run", arguments.dry_run, "say what would be done");
  verb.add_option("--report", arguments.report, "write the report as JSON to this file");
  verb.add_flag("--json", arguments.json, "print the report as JSON");
}

}  // namespace

void add_bake(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<BakeArguments>();
  BuildOptions& o = arguments->options;
  CLI::App* verb = app.add_subcommand("bake", "Make a pack from DEMs and images");
  verb->add_option("dem", arguments->inputs,
                   "DEM files, folders, glob patterns or @LIST, a text file with one of these a line; finer "
                   "ones win, then earlier ones");
  verb->add_flag("--recursive", arguments->search.recursive, "search folders with all folders in them");
  verb->add_option("-o,--output", o.session.target, "the pack to make")->required();
  verb->add_option("--tile-size", o.grid.tile_size, "samples along a tile's side")
      ->check(CLI::IsMember({257, 513}))
      ->capture_default_str();
  verb->add_option("--level", arguments->level, "finest level, or auto")->capture_default_str();
  verb->add_option("--top", o.grid.top, "coarsest level (0, or -9 for a global input)")
      ->check(CLI::Range(kMinLevel, kMaxLevel));
  verb->add_option("--region", arguments->region, "W,S,E,N in degrees: only tiles that touch it")
      ->delimiter(',')
      ->expected(4);
  add_accuracy_options(*verb, *arguments);
  verb->add_option("--rqt", o.heights.rqt_tolerance_m,
                   "also store triangulations off by less than so many metres at the finest level")
      ->check(CLI::Range(1e-4, 1e4));
  add_datum_options(*verb, *arguments);
  add_source_options(*verb, arguments->sources);
  add_imagery_options(*verb, *arguments);
  add_work_options(*verb, *arguments);
  verb->callback([arguments, &exit_code] {
    const Status status = bake(*arguments);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
