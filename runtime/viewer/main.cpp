#include <cstdlib>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "cairn/tint.h"
#include "runtime/viewer/headless.h"
#include "runtime/viewer/options.h"
#include "runtime/viewer/panel.h"
#include "runtime/viewer/settings.h"
#include "runtime/viewer/window.h"

namespace {

std::string tint_help() {
  std::string help = "colours of heights:";
  const char* between = " ";
  for (const cairn::NamedTint& tint : cairn::tints()) {
    help += between + std::string(tint.name) + " (" + std::string(tint.description) + ")";
    between = "; ";
  }
  return help;
}

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
  auto* flight = app.add_option("--flight", o.flight, "fly a recorded path, without a window");
  app.add_option("--frames", o.frames, "write each frame of the flight into this folder, as PNG")
      ->needs(flight)
      ->check(CLI::ExistingDirectory);
  app.add_option("--video", o.video, "write the flight as a film (needs ffmpeg)")->needs(flight);
  app.add_option("--stats", o.stats, "write what each frame of the flight took, as CSV")->needs(flight);
  app.add_flag(
         "--no-draw", o.no_draw,
         "do all of a frame's work but the draw calls, so that --stats measures the work on the CPU only")
      ->needs(flight);
  app.add_option("--hole-colour", o.hole_colour, "draw this colour where no terrain is, instead of the sky");
  auto* hour = app.add_option("--hour", o.hour, "local solar time of the day on which the sun stands highest")
                   ->check(CLI::Range(0.0, 24.0))
                   ->capture_default_str();
  app.add_option("--time", o.time,
                 "where the sun stands: a time UTC as 2026-06-21T15:30Z, instead of --hour; the Earth only")
      ->excludes(hour);
  app.add_option("--tolerance", o.tolerance_px,
                 "pixels that the ground may be off by, tiles and mesh together")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  app.add_option(
      "--method", o.method,
      "draw the mesh of this level-of-detail method, as cairn lab has them (default: the renderer's own)");
  app.add_option("--cache", o.cache_mib, "MiB of tiles in memory")->capture_default_str();
  app.add_option("--object-size", o.object_px, "pixels: objects that are not larger are not drawn")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  app.add_flag("--no-objects", o.no_objects, "the ground only");
  app.add_option("--samples", o.samples, "samples per pixel, which smooth edges; 1 for none")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--sea", o.sea_m,
                 "draw ground at this height and below, metres in the pack's vertical datum, as sea");
  app.add_option("--contours", o.contours_m, "metres between contour lines")->check(CLI::PositiveNumber);
  app.add_flag("--slopes", o.slopes, "colours of slopes: a class for each 5 degrees from 25 on");
  app.add_option("--tint", o.tint, tint_help());
  app.add_option("--imagery", o.imagery, "the share of imagery over the tint; 0 hides it")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--exposure", o.exposure_ev, "steps; each makes the picture twice as bright")
      ->check(CLI::Range(-10.0, 10.0))
      ->capture_default_str();
  app.add_option("--drape", o.drapes,
                 "draw the lines and points of this GeoJSON or GPX file on the ground; may be given again");
  app.add_flag("--no-shadows", o.no_shadows, "ground casts no shadows");
  app.add_flag("--no-dither", o.no_dither,
               "no noise of one step of 8 bits, which keeps the sky free of bands");
  app.add_flag("--no-fog", o.no_fog, "clear air");
  app.add_flag("--wireframe", o.wireframe, "the mesh's edges");
  app.add_flag("--levels", o.levels, "a colour for each level");
  app.footer(std::string("Keys of the window:\n") + cairn::viewer::kKeysHelp);
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
  // A window begins as the last one ended, but for what the command line says.
  if (!options.is_headless()) {
    cairn::viewer::Options kept;
    const cairn::Status read = cairn::viewer::read_settings(cairn::viewer::settings_path(), kept);
    if (!read) std::cerr << "cairn view: " << read.error().message << '\n';
    CLI::App again("Fly over a pack.", "cairn view");
    declare(again, kept);
    again.parse(argc, argv);
    if (!kept.tint.empty() && !cairn::tint_named(kept.tint)) kept.tint = options.tint;
    options = kept;
  }
  const cairn::Status done = options.is_headless() ? cairn::viewer::run_headless(options, std::cerr)
                                                   : cairn::viewer::run_window(options, std::cerr);
  if (done) return 0;
  std::cerr << "cairn view: " << done.error().message << '\n';
  return static_cast<int>(done.error().code);
}
