#include "runtime/viewer/headless.h"

#include <chrono>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <thread>

#include "runtime/flight/camera_text.h"
#include "runtime/flight/flight.h"
#include "runtime/gl/headless_context.h"
#include "runtime/paging/frame_stats.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/viewer/png_file.h"
#include "runtime/viewer/scene.h"
#include "runtime/viewer/video_pipe.h"

namespace cairn::viewer {
namespace {

void report(Scene& scene, std::ostream& messages) {
  for (const Error& error : scene.take_errors()) messages << error.message << '\n';
}

Status take_screenshot(const Options& options, Scene& scene, FrameLook look, const ViewState& view,
                       const SunTime& sun, const gl::FrameTarget& target, std::ostream& messages) {
  look.to_sun = sun_direction(view.eye, sun);
  look.waits_for_shadows = true;
  scene.load_all(view);
  scene.draw(view, 0, look, target.framebuffer());
  report(scene, messages);
  return write_png(options.screenshot, target.read());
}

std::filesystem::path frame_path(const Options& options, std::size_t frame) {
  std::ostringstream name;
  name << "frame-" << std::setw(6) << std::setfill('0') << frame << ".png";
  return options.frames / name.str();
}

class FlightRun {
 public:
  FlightRun(const Options& options, const Flight& flight, const SunTime& sun, Scene& scene,
            const gl::FrameTarget& target)
      : options_(options), flight_(flight), sun_(sun), scene_(scene), target_(target) {}

  Status run(FrameLook look, ViewState view, std::ostream& messages) {
    const Status opened = open_outputs();
    if (!opened) return opened;
    // What came before the flight is not of it: tiles waited for, and the first frame, which uploads them
    // all.
    scene_.load_all(at(view, 0));
    scene_.draw_list(at(view, 0), look, target_.framebuffer());
    began_ = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < flight_.frame_count(); ++i) {
      view = at(view, i);
      look.to_sun = sun_direction(view.eye, sun_);
      look.frame_s = 1 / flight_.frames_per_second;
      const Status done = frame(i, view, look);
      if (!done) return done;
      report(scene_, messages);
    }
    if (!options_.stats.empty() && !stats_.flush())
      return failed(options_.stats.string() + ": stats: expected to write them, found that it cannot be");
    return video_ ? video_->finish() : Status{};
  }

 private:
  ViewState at(ViewState view, std::size_t frame) const {
    const ViewState there = flight_.at(static_cast<double>(frame) / flight_.frames_per_second);
    view.eye = there.eye;
    view.height_m = there.height_m;
    view.heading_deg = there.heading_deg;
    view.pitch_deg = there.pitch_deg;
    return view;
  }

  Status open_outputs() {
    if (!options_.stats.empty()) {
      stats_.open(options_.stats, std::ios::trunc);
      stats_ << "frame,update_ms,draw_ms,upload_ms,patches,triangles,uploads,gpu_bytes,resident_bytes,"
                "complete,error_px,texel_px,gpu_ms,objects,billboards,object_calls,object_triangles,models\n";
    }
    if (options_.video.empty()) return {};
    Result<VideoPipe> pipe =
        VideoPipe::open(options_.video, target_.width(), target_.height(), flight_.frames_per_second);
    if (!pipe) return pipe.error();
    video_ = std::move(*pipe);
    return {};
  }

  Status frame(std::size_t index, const ViewState& view, const FrameLook& look) {
    const bool keeps = !options_.frames.empty() || video_;
    // A picture waits for what it shows; a measured frame comes when it is due, like a window's.
    if (keeps) {
      scene_.load_all(view);
    } else {
      std::this_thread::sleep_until(
          began_ + std::chrono::duration<double>(static_cast<double>(index) / flight_.frames_per_second));
    }
    const double begin = 1e3 * thread_cpu_s();
    scene_.update(view, 1 / flight_.frames_per_second);
    const double updated = 1e3 * thread_cpu_s();
    FrameLook shown = look;
    shown.waits_for_shadows = keeps;
    const FrameCounts counts = scene_.draw_list(view, shown, target_.framebuffer());
    const double drawn = 1e3 * thread_cpu_s();
    if (stats_.is_open()) {
      stats_ << index << ',' << updated - begin << ',' << drawn - updated << ',' << counts.upload_ms << ','
             << counts.patches << ',' << counts.triangles << ',' << counts.uploads << ',' << counts.gpu_bytes
             << ',' << scene_.terrain().stats().resident_bytes << ',' << scene_.list()->is_complete << ','
             << scene_.list()->error_px << ',' << scene_.list()->texel_px << ',';
      if (counts.gpu_ms) stats_ << *counts.gpu_ms;
      stats_ << ',' << counts.objects << ',' << counts.billboards << ',' << counts.object_calls << ','
             << counts.object_triangles << ',' << scene_.terrain().stats().models_resident << '\n';
    }
    if (!keeps) return {};
    const gl::Picture picture = target_.read();
    if (video_) {
      const Status written = video_->add(picture);
      if (!written) return written;
    }
    return options_.frames.empty() ? Status{} : write_png(frame_path(options_, index), picture);
  }

  const Options& options_;
  const Flight& flight_;
  const SunTime& sun_;
  Scene& scene_;
  const gl::FrameTarget& target_;
  std::ofstream stats_;
  std::optional<VideoPipe> video_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace

namespace {

/// An output that is the pack or the flight would destroy it.
Status check_outputs(const Options& options) {
  struct Output {
    const char* option;
    const std::filesystem::path& path;
  };
  for (const Output& output : {Output{"--screenshot", options.screenshot}, Output{"--video", options.video},
                               Output{"--stats", options.stats}}) {
    for (const std::filesystem::path& input : {options.pack, options.flight}) {
      std::error_code none;
      if (output.path.empty() || !std::filesystem::equivalent(output.path, input, none)) continue;
      return usage_error(std::string(output.option) + ": expected a file that is not read, found " +
                         output.path.string());
    }
  }
  return {};
}

}  // namespace

Status run_headless(const Options& options, std::ostream& messages) {
  if (const Status status = check_outputs(options); !status) return status;
  const Result<Size> size = parse_size(options.size);
  if (!size) return size.error();
  std::optional<Flight> flight;
  if (!options.flight.empty()) {
    Result<Flight> read = read_flight(options.flight);
    if (!read) return read.error();
    flight = std::move(*read);
  }
  Result<gl::HeadlessContext> context = gl::HeadlessContext::create();
  if (!context) return context.error();
  Result<Scene> scene = Scene::open(options);
  if (!scene) return scene.error();
  const Result<ViewState> view = view_of(options, scene->pack(), *size);
  if (!view) return view.error();
  const Result<FrameLook> look = look_of(options, scene->pack());
  if (!look) return look.error();
  const Result<SunTime> sun = sun_time_of(options, scene->pack());
  if (!sun) return sun.error();
  const Result<gl::FrameTarget> target = gl::FrameTarget::create(size->width, size->height, options.samples);
  if (!target) return target.error();
  if (!options.screenshot.empty()) {
    const Status taken = take_screenshot(options, *scene, *look, *view, *sun, *target, messages);
    if (!taken || !flight) return taken;
  }
  return FlightRun(options, *flight, *sun, *scene, *target).run(*look, *view, messages);
}

}  // namespace cairn::viewer
