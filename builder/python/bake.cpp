#include "builder/python/bake.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "builder/bake/memory_budget.h"
#include "builder/python/errors.h"
#include "builder/raster/body_placement.h"
#include "builder/raster/expand_inputs.h"
#include "cairn/build.h"

namespace cairn {
namespace py = pybind11;
namespace {

using Path = std::filesystem::path;
using Bounds = std::tuple<double, double, double, double>;

constexpr auto kSignalPause = std::chrono::milliseconds(50);

/// The value that a word stands for.
template <class Value>
Value value_of(const char* argument, const std::string& word, const std::map<std::string, Value>& words) {
  const auto found = words.find(word);
  if (found != words.end()) return found->second;
  std::string expected;
  for (const auto& known : words) expected += (expected.empty() ? "" : ", ") + known.first;
  raise(usage_error(std::string(argument) + ": expected one of " + expected + ", found " + word));
}

GeoBounds bounds_of(const char* argument, const Bounds& b) {
  const auto [west, south, east, north] = b;
  if (west < east && south < north && south >= -90 && north <= 90 && west >= -360 && east <= 360)
    return {west, south, east, north};
  raise(
      usage_error(std::string(argument) + ": expected (west, south, east, north) in degrees, found others"));
}

/// Files, folders and glob patterns as the program `cairn` takes them; one of them or a list.
std::vector<Path> files_of(const py::object& inputs) {
  std::vector<std::string> arguments;
  const bool is_one = py::isinstance<py::str>(inputs) || py::hasattr(inputs, "__fspath__");
  const py::object fspath = py::module_::import("os").attr("fspath");
  if (is_one) {
    arguments.push_back(py::cast<std::string>(fspath(inputs)));
  } else {
    for (const py::handle input : inputs) arguments.push_back(py::cast<std::string>(fspath(input)));
  }
  auto found = expand_inputs(arguments);
  if (!found) raise(found.error());
  return std::move(found->files);
}

/// What a bake and the thread that waits for it share.
struct Watch {
  std::mutex mutex;
  std::condition_variable ended_changed;
  bool ended = false;             // guarded by mutex
  std::exception_ptr from_build;  // guarded by mutex
  std::atomic<bool> interrupted = false;
  bool declined = false;                               // under the GIL: the callback returned False
  std::optional<py::error_already_set> from_callback;  // under the GIL
};

/// Tells the callback; returns whether the bake goes on.
bool tell(const py::object& callback, const Progress& progress, Watch& watch) {
  if (watch.interrupted) return false;
  if (callback.is_none()) return true;
  const py::gil_scoped_acquire gil;
  if (watch.declined || watch.from_callback) return false;
  try {
    const py::object answer = callback(progress.stage, progress.done, progress.total);
    watch.declined = answer.ptr() == Py_False;
  } catch (py::error_already_set& error) {
    watch.from_callback.emplace(std::move(error));
  }
  return !watch.declined && !watch.from_callback;
}

/// Bakes in a thread of its own, so that this one, which holds the GIL, can see Ctrl-C.
Result<BuildReport> build_watched(const BuildOptions& options, const py::object& callback, Watch& watch) {
  std::optional<Result<BuildReport>> result;
  std::thread bake([&] {
    try {
      result = build(options, [&](const Progress& progress) { return tell(callback, progress, watch); });
    } catch (...) {
      watch.from_build = std::current_exception();
    }
    const std::lock_guard lock(watch.mutex);
    watch.ended = true;
    watch.ended_changed.notify_one();
  });
  std::optional<py::error_already_set> signal;
  for (bool ended = false; !ended;) {
    {
      const py::gil_scoped_release release;
      std::unique_lock lock(watch.mutex);
      ended = watch.ended_changed.wait_for(lock, kSignalPause, [&] { return watch.ended; });
    }
    if (!signal && PyErr_CheckSignals() != 0) {
      signal.emplace();
      watch.interrupted = true;
    }
  }
  {
    const py::gil_scoped_release release;
    bake.join();
  }
  if (signal) throw std::move(*signal);
  if (watch.from_callback) throw std::move(*watch.from_callback);
  if (watch.from_build) std::rethrow_exception(watch.from_build);
  return *std::move(result);
}

std::string words_for(Remedy remedy) {
  switch (remedy) {
    case Remedy::replace_target:
      return "force=True replaces it";
    case Remedy::accept_error:
      return "allow_error=True bakes all the same";
    case Remedy::tell_body:
      return "body=\"NAME,a,b\" says which";
    case Remedy::tell_latitude:
      return "latitude=\"planetographic\" or \"planetocentric\" says it";
    case Remedy::resume:
      return "what is baked stays beside the target, and resume=True goes on from there";
    case Remedy::discard_work:
      return "force=True discards it";
  }
  return "";
}

py::dict report_of(const BuildReport& report) {
  py::dict out;
  out["metadata"] = py::module_::import("json").attr("loads")(report.metadata_json);
  out["within_error_bound"] = report.within_error_bound;
  out["samples"] = report.samples;
  out["texels"] = report.texels;
  out["file_bytes"] = report.file_bytes;
  out["seconds"] = report.seconds;
  out["threads"] = report.threads;
  out["resumed"] = report.resumed;
  return out;
}

void check_memory(const BuildOptions& options) {
  const int threads = options.session.threads > 0 ? options.session.threads
                                                  : static_cast<int>(std::thread::hardware_concurrency());
  const std::size_t least = least_memory(threads, options.grid.tile_size, !options.imagery.inputs.empty());
  if (options.session.memory_bytes >= least) return;
  raise(usage_error("memory_mib: expected " + std::to_string((least >> 20) + 1) + " or more for " +
                    std::to_string(threads) + " threads, found " +
                    std::to_string(options.session.memory_bytes >> 20)));
}

SourceOverrides place_of_sources(const std::optional<std::string>& body,
                                 const std::optional<std::string>& latitude,
                                 const std::optional<std::string>& longitude) {
  SourceOverrides said;
  if (body) {
    if (const auto parsed = parse_body(*body); !parsed) raise(parsed.error());
    said.body = body;
  }
  if (latitude)
    said.latitude = value_of<LatitudeKind>(
        "latitude", *latitude,
        {{"planetographic", LatitudeKind::planetographic}, {"planetocentric", LatitudeKind::planetocentric}});
  if (longitude)
    said.longitude = value_of<LongitudeSense>(
        "longitude", *longitude, {{"east", LongitudeSense::east}, {"west", LongitudeSense::west}});
  return said;
}

py::dict bake(const py::object& inputs, const Path& target, const py::object& imagery,
              std::optional<int> level, std::optional<int> top, int tile_size, std::optional<Bounds> region,
              std::optional<double> max_error_m, std::optional<double> quantum_m, bool allow_error,
              const std::string& resampling, const std::string& void_mode,
              const std::optional<std::string>& datum, std::optional<Path> geoid,
              const std::optional<std::string>& body, const std::optional<std::string>& latitude,
              const std::optional<std::string>& longitude, std::optional<float> rqt_tolerance_m,
              const std::string& texture_format, const std::string& texture_quality,
              std::optional<Bounds> imagery_bounds, double feather_pixels, std::size_t memory_mib,
              int threads, bool resume, bool force, const py::object& progress) {
  BuildOptions o;
  o.mosaic.inputs = files_of(inputs);
  o.imagery.inputs = files_of(imagery);
  if (o.mosaic.inputs.empty() && o.imagery.inputs.empty())
    raise(usage_error("bake: expected DEMs or images, found neither"));
  if (tile_size != 257 && tile_size != 513)
    raise(usage_error("tile_size: expected 257 or 513, found " + std::to_string(tile_size)));
  for (const auto& [name, number] : {std::pair("level", level), {"top", top}}) {
    if (number && (*number < kMinLevel || *number > kMaxLevel))
      raise(usage_error(std::string(name) + ": expected -9 to 20, found " + std::to_string(*number)));
  }
  for (const auto& [name, metres] : {std::pair("max_error_m", max_error_m), {"quantum_m", quantum_m}}) {
    if (metres && !(*metres >= 1e-5 && *metres <= 1e4))
      raise(usage_error(std::string(name) + ": expected metres of 0.00001 to 10000, found " +
                        std::to_string(*metres)));
  }
  if (rqt_tolerance_m && !(*rqt_tolerance_m >= 1e-4f && *rqt_tolerance_m <= 1e4f))
    raise(usage_error("rqt_tolerance_m: expected metres of 0.0001 to 10000, found " +
                      std::to_string(*rqt_tolerance_m)));
  if (!(feather_pixels >= 0 && feather_pixels <= 1e6))
    raise(usage_error("feather_pixels: expected 0 to 1000000, found " + std::to_string(feather_pixels)));
  if (threads < 0 || threads > 1024)
    raise(usage_error("threads: expected 0 to 1024, found " + std::to_string(threads)));
  o.grid.tile_size = tile_size;
  o.grid.top = top;
  if (region) o.grid.region = bounds_of("region", *region);
  o.mosaic.level = level;
  o.mosaic.max_error_m = max_error_m;
  o.mosaic.resampling = value_of<ResampleMethod>("resampling", resampling,
                                                 {{"nearest", ResampleMethod::nearest},
                                                  {"bilinear", ResampleMethod::bilinear},
                                                  {"cubic", ResampleMethod::cubic},
                                                  {"exact", ResampleMethod::exact},
                                                  {"smooth", ResampleMethod::smooth}});
  if (datum) {
    o.mosaic.datum = value_of<VerticalDatum>("datum", *datum,
                                             {{"unknown", VerticalDatum::unknown},
                                              {"egm96", VerticalDatum::egm96},
                                              {"ellipsoid", VerticalDatum::ellipsoid}});
  }
  o.mosaic.geoid = geoid;
  if (const SourceOverrides said = place_of_sources(body, latitude, longitude); said != SourceOverrides{}) {
    o.mosaic.source_rules = {{"*", said}};
    o.imagery.source_rules = {{"*", said}};
  }
  o.heights.quantum_m = quantum_m;
  o.heights.allow_error = allow_error;
  o.heights.voids =
      value_of<VoidMode>("void", void_mode, {{"fill", VoidMode::fill}, {"keep", VoidMode::keep}});
  o.heights.rqt_tolerance_m = rqt_tolerance_m;
  o.imagery.format = value_of<TextureFormat>(
      "texture_format", texture_format,
      {{"bc1", TextureFormat::bc1}, {"bc3", TextureFormat::bc3}, {"bc7", TextureFormat::bc7}});
  o.imagery.quality = value_of<TextureQuality>(
      "texture_quality", texture_quality,
      {{"fast", TextureQuality::fast}, {"normal", TextureQuality::normal}, {"best", TextureQuality::best}});
  if (imagery_bounds) o.imagery.bounds = bounds_of("imagery_bounds", *imagery_bounds);
  o.imagery.feather_pixels = feather_pixels;
  o.session.target = target;
  o.session.memory_bytes = memory_mib << 20;
  o.session.threads = threads;
  o.session.resume = resume;
  o.session.force = force;
  check_memory(o);

  Watch watch;
  const Result<BuildReport> report = build_watched(o, progress, watch);
  if (!report) {
    Error error = report.error();
    for (const Remedy remedy : remedies_for(error, o)) error.message += "; " + words_for(remedy);
    if (watch.declined) raise_cancelled(error.message);
    raise(error);
  }
  if (!report->warning.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, report->warning.c_str(), 1) != 0)
    throw py::error_already_set();
  return report_of(*report);
}

constexpr const char* kBakeAbout =
    R"(Makes a pack from DEMs and images, as the program `cairn bake` does, and returns its report.

inputs, imagery: one path or a list; folders and glob patterns are searched for rasters.
target: the pack to make. It appears when it is whole, or not at all.
level, top: finest and coarsest level; region: (west, south, east, north) in degrees.
max_error_m: error bound; no post is off by more. quantum_m: step in which heights are stored.
resampling: smooth, exact, cubic, bilinear or nearest. void: fill or keep.
datum: unknown, egm96 or ellipsoid; None for what the DEMs say, which then has to be one datum; geoid: raster of undulations to add.
body: "Mars", "NAME,a,b" or "a,b" with the semi-axes of the pack's ellipsoid in metres; latitude: planetographic or planetocentric; longitude: east or west; None for what the sources say.
rqt_tolerance_m: also store triangulations off by less than so many metres at the finest level.
texture_format: bc1, bc3 or bc7; texture_quality: fast, normal or best.
memory_mib: MiB that the process stays under; threads: 0 for all.
resume: go on with an interrupted bake; force: replace the target.
progress: is called with (stage, done, total) after each unit of tiles, in another thread; the bake ends with
Cancelled where it returns False, and with its exception where it raises one. Ctrl-C ends the bake, too.

The report has: metadata, within_error_bound, samples, texels, file_bytes, seconds, threads, resumed.
The GIL is released while the bake works.)";

}  // namespace

void add_bake(py::module_& module) {
  const BuildOptions defaults;
  module.def("bake", &bake, kBakeAbout, py::arg("inputs"), py::arg("target"), py::kw_only(),
             py::arg("imagery") = py::tuple(), py::arg("level") = py::none(), py::arg("top") = py::none(),
             py::arg("tile_size") = defaults.grid.tile_size, py::arg("region") = py::none(),
             py::arg("max_error_m") = py::none(), py::arg("quantum_m") = py::none(),
             py::arg("allow_error") = false, py::arg("resampling") = "smooth", py::arg("void") = "fill",
             py::arg("datum") = py::none(), py::arg("geoid") = py::none(), py::arg("body") = py::none(),
             py::arg("latitude") = py::none(), py::arg("longitude") = py::none(),
             py::arg("rqt_tolerance_m") = py::none(), py::arg("texture_format") = "bc1",
             py::arg("texture_quality") = "normal", py::arg("imagery_bounds") = py::none(),
             py::arg("feather_pixels") = 0.0, py::arg("memory_mib") = defaults.session.memory_bytes >> 20,
             py::arg("threads") = 0, py::arg("resume") = false, py::arg("force") = false,
             py::arg("progress") = py::none());
}

}  // namespace cairn
