#include <cstdlib>
#include <iostream>

#include <CLI/CLI.hpp>

#include "runtime/viewer/headless.h"
#include "runtime/viewer/options.h"

namespace {

void declare(CLI::App& app, cairn::viewer::Options& o) {
  app.add_option("pack", o.pack, "the pack to fly over")->required();
  app.add_option(
      "--camera", o.camera,
      "LON,LAT,ALT,HEADING,PITCH: degrees and metres in the pack's vertical datum; heading clockwise "
      "from north, pitch up from the horizon (default: the pack's bounds fill the view)");
  app.add_option("--fov", o.fov_deg, "vertical field of view in degrees")
      ->check(CLI::Range(0.1, 170.0))
      ->capture_default_str();
  app.add_option("--size", o.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  app.add_option("--screenshot", o.screenshot, "write one picture, without a window, when all is loaded");
  app.add_option("--hole-colour", o.hole_colour, "draw this colour where no terrain is, instead of the sky");
  app.add_option("--hour", o.hour, "local solar time, 0 to 24")
      ->check(CLI::Range(0.0, 24.0))
      ->capture_default_str();
  app.add_option("--tolerance", o.tolerance_px, "pixels of error that the mesh may add")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  app.add_option("--cache", o.cache_mib, "MiB of tiles in memory")->capture_default_str();
  app.add_flag("--no-fog", o.no_fog, "clear air");
  app.add_flag("--wireframe", o.wireframe, "the mesh's edges");
  app.add_flag("--levels", o.levels, "a colour for each level");
}

}  // namespace

int main(int argc, char** argv) {
  cairn::viewer::Options options;
  CLI::App app("Fly over a pack.", "cairn view");
  declare(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  const cairn::Status done = cairn::viewer::run_headless(options, std::cerr);
  if (done) return 0;
  std::cerr << "cairn view: " << done.error().message << '\n';
  return static_cast<int>(done.error().code);
}
