#include "builder/app/bake_options.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "builder/app/one_of.h"
#include "builder/app/region_argument.h"
#include "builder/bake/memory_budget.h"
#include "builder/raster/source_overrides.h"

namespace cairn {
namespace {

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

Status use_region(const std::vector<double>& numbers, std::optional<GeoBounds>& out) {
  if (numbers.empty()) return {};
  const auto region = region_of(numbers);
  if (!region) return region.error();
  out = *region;
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

/// A pattern of --sources that no DEM matches is a slip of the pen.
Status check_rules(const MosaicOptions& mosaic) {
  for (const SourceRule& rule : mosaic.source_rules) {
    const auto matches = [&](const std::filesystem::path& dem) { return matches_glob(dem, rule.glob); };
    if (rule.glob == "*" || std::any_of(mosaic.inputs.begin(), mosaic.inputs.end(), matches)) continue;
    return usage_error(fmt::format("--sources: expected patterns that DEMs match, found {}", rule.glob));
  }
  return {};
}

void add_grid_options(CLI::App& verb, BakeArguments& arguments) {
  BuildOptions& o = arguments.options;
  verb.add_option("--tile-size", o.grid.tile_size, "samples along a tile's side")
      ->check(CLI::IsMember({257, 513}))
      ->capture_default_str();
  verb.add_option("--level", arguments.level, "finest level, or auto")->capture_default_str();
  verb.add_option("--top", o.grid.top, "coarsest level (0, or -9 for a global input)")
      ->check(CLI::Range(kMinLevel, kMaxLevel));
  verb.add_option("--region", arguments.region, "W,S,E,N in degrees: only tiles that touch it")
      ->delimiter(',')
      ->expected(4);
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
  verb.add_option("--void-distance", o.mosaic.void_posts,
                  "posts from one with a value up to which voids are filled; by default any distance")
      ->check(CLI::Range(0.0, 256.0));
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
  verb.add_option("--image-range", arguments.image_range,
                  "LOW,HIGH: samples of the images that become black and white; by default 0 and the most of "
                  "their bits")
      ->delimiter(',')
      ->expected(2);
  verb.add_option("--feather", o.feather_pixels, "pixels over which an image's rim fades into those beneath")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
}

void add_object_options(CLI::App& verb, BakeArguments& arguments) {
  verb.add_option(
      "--objects", arguments.places,
      "objects on the ground: CSV (lon,lat,model[,heading,scale,height,mode]), GeoJSON or what GDAL reads; "
      "polygons scatter objects");
  verb.add_option(
      "--models", arguments.models,
      "the folder with their models: NAME.glb, .gltf, .obj, .dxf, ..., and images NAME.WxH.png of W by H "
      "metres");
}

Status use_objects(const BakeArguments& arguments, ObjectOptions& objects) {
  if (arguments.places.empty() != arguments.models.empty())
    return usage_error(arguments.places.empty() ? "--models: expected --objects with it, found none"
                                                : "--objects: expected --models with it, found none");
  objects.models = arguments.models;
  for (const std::string& file : arguments.places) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
      return usage_error(file + ": objects: expected a file, found none");
    objects.places.emplace_back(file);
  }
  if (arguments.models.empty() || std::filesystem::is_directory(objects.models)) return {};
  return usage_error(arguments.models + ": models: expected a folder, found none");
}

}  // namespace

Status find_inputs(const std::vector<std::string>& arguments, const InputSearch& search,
                   std::vector<std::filesystem::path>& out) {
  auto found = expand_inputs(arguments, search);
  if (!found) return found.error();
  for (const auto& file : found->without_raster)
    fmt::print(stderr, "cairn: warning: {}: passed over, since no raster is in it\n", file.string());
  out = std::move(found->files);
  return {};
}

Result<BuildOptions> options_from(const BakeArguments& arguments) {
  BuildOptions options = arguments.options;
  if (auto status = use_region(arguments.region, options.grid.region); !status) return status.error();
  if (auto status = use_bounds("--bounds", arguments.image_bounds, options.imagery.bounds); !status)
    return status.error();
  if (auto status = use_level(arguments.level, options); !status) return status.error();
  if (const auto& range = arguments.image_range; !range.empty() && !(range[0] < range[1]))
    return usage_error("--image-range: expected LOW below HIGH, found " + std::to_string(range[0]) + " and " +
                       std::to_string(range[1]));
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
  options.imagery.source_rules = image_rules(arguments.sources, arguments.image_range);
  if (auto status = check_rules(options.mosaic); !status) return status.error();
  if (auto status = find_inputs(arguments.images, arguments.search, options.imagery.inputs); !status)
    return status.error();
  if (auto status = use_objects(arguments, options.objects); !status) return status.error();
  if (auto status = use_memory(arguments.memory_mib, options); !status) return status.error();
  return options;
}

void add_bake_options(CLI::App& verb, BakeArguments& arguments) {
  verb.add_option("dem", arguments.inputs,
                  "DEM files, folders, glob patterns or @LIST, a text file with one of these a line; finer "
                  "ones win, then earlier ones");
  verb.add_flag("--recursive", arguments.search.recursive, "search folders with all folders in them");
  add_grid_options(verb, arguments);
  add_accuracy_options(verb, arguments);
  verb.add_option("--rqt", arguments.options.heights.rqt_tolerance_m,
                  "also store triangulations off by less than so many metres at the finest level")
      ->check(CLI::Range(1e-4, 1e4));
  add_datum_options(verb, arguments);
  add_source_options(verb, arguments.sources);
  add_imagery_options(verb, arguments);
  add_object_options(verb, arguments);
}

void add_machine_options(CLI::App& verb, BakeArguments& arguments) {
  verb.add_option("--memory", arguments.memory_mib, "MiB that the program stays under")
      ->capture_default_str();
  verb.add_option("--threads", arguments.options.session.threads, "0 for all")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

}  // namespace cairn
