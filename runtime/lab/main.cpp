#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "runtime/flight/camera_text.h"
#include "runtime/lab/camera_path.h"
#include "runtime/lab/compare.h"
#include "runtime/lab/draw_charts.h"
#include "runtime/lab/flight_loads.h"
#include "runtime/lab/mesh_file.h"
#include "runtime/lab/report.h"

namespace cairn {
namespace {

struct Options {
  std::filesystem::path pack;
  std::vector<std::string> flights{"low"};
  std::string methods = "all";
  std::string tolerances = "0.5,1,2,4,8";
  std::string size = "1920x1080";
  std::filesystem::path out;
  std::size_t frames = 24;
  std::string tiles = "error";
  int threads = 0;
  bool no_charts = false;
  bool bound = false;
  LodOptions lod;

  std::string camera;
  std::string method = "full";
  double tolerance_px = 1;
  double fov_deg = 60;
  std::filesystem::path mesh;
  std::uint64_t cache_mib = 512;
  double look_ahead_s = TerrainOptions().look_ahead_s;
  bool cull = false;
  bool ecef = false;
};

void declare_common(CLI::App& app, Options& o) {
  app.add_option("pack", o.pack, "the pack")->required();
  app.add_option("--size", o.size, "of the viewport, in pixels: WxH");
  app.add_option(
         "--tiles", o.tiles,
         "map: what the runtime shows, refined where a tile's own error may project above half of the "
         "tolerance, with the ring of tiles around the eye; error: without the ring")
      ->check(CLI::IsMember({"map", "error"}));
  app.add_flag("--roughness", o.lod.roughness, "quadtree: split rough ground further");
  app.add_flag("--geomorph", o.lod.geomorph, "block: change heights gradually from level to level");
  app.add_flag("--angle-compensation", o.lod.angle_compensation, "quadtree: split less when looking ahead");
}

std::string names_of_flights() {
  std::string names;
  for (const std::string_view name : built_in_flights())
    names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

void declare_compare(CLI::App& app, Options& o) {
  declare_common(app, o);
  app.add_option("--flight", o.flights,
                 "files of cairn-view, or of " + names_of_flights() + "; several, or all");
  app.add_option("--methods", o.methods, "names parted by commas, or all");
  app.add_option("--tolerance", o.tolerances, "pixels, parted by commas");
  app.add_option("--frames", o.frames, "of a flight")->check(CLI::Range(2, 100000));
  app.add_option("--threads", o.threads, "of the measure; 0 for all")->check(CLI::Range(0, 1024));
  app.add_option("--out", o.out, "folder for the CSV, the JSON and the page")->required();
  app.add_flag(
      "--bound", o.bound,
      "also the triangles of a greedy TIN for each frame, about the fewest; takes seconds per frame");
  app.add_flag("--no-charts", o.no_charts, "no page: the charts need python3-matplotlib");
}

void declare_mesh(CLI::App& app, Options& o) {
  declare_common(app, o);
  app.add_option("--camera", o.camera, "LON,LAT,ALT,HEADING,PITCH, degrees and metres")->required();
  app.add_option("--fov", o.fov_deg, "between top and bottom, degrees")->check(CLI::Range(1.0, 170.0));
  app.add_option("--method", o.method, "how the mesh is made");
  app.add_option("--tolerance", o.tolerance_px, "pixels")->check(CLI::Range(1e-6, 1e6));
  app.add_option("-o,--output", o.mesh, "OUT.obj or OUT.ply")->required();
  app.add_flag("--cull", o.cull, "only what may be visible");
  app.add_flag("--ecef", o.ecef, "vertices in geocentric metres");
}

void declare_load(CLI::App& app, Options& o) {
  app.add_option("pack", o.pack, "the pack")->required();
  app.add_option("--size", o.size, "of the viewport, in pixels: WxH");
  app.add_option("--flight", o.flights,
                 "files of cairn-view, or of " + names_of_flights() + "; several, or all");
  app.add_option("--tolerance", o.tolerance_px, "pixels")->check(CLI::Range(1e-6, 1e6));
  app.add_option("--frames", o.frames, "of a flight, 0.1 s each")->check(CLI::Range(2, 100000));
  app.add_option("--cache", o.cache_mib, "MiB of tiles in memory")->check(CLI::Range(1, 1 << 20));
  app.add_option("--look-ahead", o.look_ahead_s, "seconds; 0 for none")->check(CLI::Range(0.0, 3600.0));
}

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    words.push_back(list.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

Error unknown_method(const std::string& name) {
  std::string names;
  for (const LodMethodInfo* method : lod_methods())
    names += (names.empty() ? "" : ", ") + std::string(method->name);
  return usage_error("method: expected one of " + names + ", found \"" + name + "\"");
}

/// Every method, and the methods that have options with them too.
std::vector<Contender> all_contenders() {
  std::vector<Contender> contenders;
  for (const LodMethodInfo* method : lod_methods())
    contenders.push_back({std::string(method->name), method, {}});
  contenders.push_back({"quadtree+rough", lod_method("quadtree"), {true, false, false}});
  contenders.push_back({"quadtree+rough+angle", lod_method("quadtree"), {true, true, false}});
  contenders.push_back({"block+morph", lod_method("block"), {false, false, true}});
  return contenders;
}

/// A name with a + brings its options; others take those of the command line.
Result<std::vector<Contender>> contenders_of(const Options& o) {
  std::vector<Contender> all = all_contenders();
  if (o.methods == "all") return all;
  std::vector<Contender> contenders;
  for (const std::string& name : words_of(o.methods)) {
    const auto known =
        std::find_if(all.begin(), all.end(), [&](const Contender& c) { return c.label == name; });
    if (known == all.end()) return unknown_method(name);
    contenders.push_back(*known);
    if (name == known->method->name) contenders.back().options = o.lod;
  }
  return contenders;
}

Result<std::vector<double>> tolerances_of(const std::string& list) {
  std::vector<double> tolerances;
  for (const std::string& word : words_of(list)) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !(value > 0 && std::isfinite(value))) {
      return usage_error("--tolerance: expected pixels above 0, found \"" + word + "\"");
    }
    tolerances.push_back(value);
  }
  return tolerances;
}

Result<LabTerrain> open_terrain(const Options& o) {
  Result<PackReader> pack = PackReader::open(o.pack);
  if (!pack) return pack.error();
  if (const Status status = pack->read_index(); !status) return status.error();
  return LabTerrain(std::make_shared<const PackReader>(std::move(*pack)));
}

SceneRules rules_of(const Options& o) {
  return {RefinementPattern::restricted, kTileShare, o.tiles == "map"};
}

Result<CompareSpec> spec_of(const Options& o) {
  CompareSpec spec;
  auto contenders = contenders_of(o);
  if (!contenders) return contenders.error();
  auto tolerances = tolerances_of(o.tolerances);
  if (!tolerances) return tolerances.error();
  const auto size = viewer::parse_size(o.size);
  if (!size) return size.error();
  const int all = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return CompareSpec{std::move(*contenders), std::move(*tolerances),          rules_of(o), size->width,
                     size->height,           o.threads > 0 ? o.threads : all, o.bound};
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) return failed(path.string() + ": expected to write, found no room or no right to");
  return {};
}

std::vector<std::string> flights_of(const Options& o) {
  if (o.flights != std::vector<std::string>{"all"}) return o.flights;
  return {built_in_flights().begin(), built_in_flights().end()};
}

Status run_compare(const Options& o) {
  const auto spec = spec_of(o);
  if (!spec) return spec.error();
  auto terrain = open_terrain(o);
  if (!terrain) return terrain.error();
  CompareReport report{o.pack.filename().string(), machine_name(), {}};
  std::string csv = csv_header();
  for (const std::string& flight : flights_of(o)) {
    const auto path = camera_path(flight, *terrain, o.frames);
    if (!path) return path.error();
    const Status status = compare(*terrain, *path, *spec, [&](const FrameRecord& record) {
      csv += to_csv(record);
      report.records.push_back(record);
    });
    if (!status) return status;
    std::cerr << "cairn-lab: " << path->name << ": " << path->views.size() << " frames\n";
  }
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  if (const Status status = write_text(o.out / "frames.csv", csv); !status) return status;
  if (const Status status = write_text(o.out / "summary.json", to_json(report)); !status) return status;
  return o.no_charts ? Status{} : draw_charts(o.out);
}

Status run_load(const Options& o) {
  Result<PackReader> opened = PackReader::open(o.pack);
  if (!opened) return opened.error();
  const auto pack = std::make_shared<const PackReader>(std::move(*opened));
  const auto size = viewer::parse_size(o.size);
  if (!size) return size.error();
  LabTerrain terrain(pack);
  TerrainOptions options;
  options.cache_bytes = o.cache_mib << 20;
  options.tolerance_px = o.tolerance_px;
  options.look_ahead_s = o.look_ahead_s;
  std::cout << flight_loads_header();
  for (const std::string& flight : flights_of(o)) {
    auto path = camera_path(flight, terrain, o.frames);
    if (!path) return path.error();
    for (ViewState& view : path->views) {
      view.viewport_width_px = size->width;
      view.viewport_height_px = size->height;
    }
    const auto loads = loads_of(pack, *path, options);
    if (!loads) return loads.error();
    std::cout << to_row(*loads) << std::flush;
  }
  return {};
}

Status run_mesh(const Options& o) {
  const LodMethodInfo* method = lod_method(o.method);
  if (!method) return unknown_method(o.method);
  Result<ViewState> view = viewer::parse_camera(o.camera);
  if (!view) return view.error();
  const auto size = viewer::parse_size(o.size);
  if (!size) return size.error();
  view->viewport_width_px = size->width;
  view->viewport_height_px = size->height;
  view->fov_y_deg = o.fov_deg;
  auto terrain = open_terrain(o);
  if (!terrain) return terrain.error();
  view->ellipsoid = terrain->pack().header().body.shape;
  SceneRules rules = rules_of(o);
  rules.refine_px *= o.tolerance_px;
  const auto scene = terrain->scene_for(*view, rules);
  if (!scene) return scene.error();
  const auto lod = method->create(o.lod);
  lod->prepare(*scene);
  return write_mesh(lod->build(*scene, {*view, o.tolerance_px, o.cull}), o.mesh,
                    o.ecef ? std::optional(view->ellipsoid) : std::nullopt);
}

int report(const Status& status) {
  if (status) return 0;
  std::cerr << "cairn-lab: " << status.error().message << "\n";
  return static_cast<int>(status.error().code);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  CLI::App app("Measures level-of-detail methods on the tiles of a pack.", "cairn-lab");
  cairn::Options options;
  app.require_subcommand(1);
  CLI::App* compare = app.add_subcommand("compare", "fly every method along flights and draw the charts");
  cairn::declare_compare(*compare, options);
  CLI::App* load =
      app.add_subcommand("load", "count what a terrain loads along flights, and what no view saw");
  cairn::declare_load(*load, options);
  CLI::App* mesh = app.add_subcommand("mesh", "write the mesh of a camera's scene");
  cairn::declare_mesh(*mesh, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "cairn-lab: " << error.what() << "\n";
    return static_cast<int>(cairn::ErrorCode::usage);
  }
  if (compare->parsed()) return cairn::report(cairn::run_compare(options));
  return cairn::report(load->parsed() ? cairn::run_load(options) : cairn::run_mesh(options));
}
