#include "runtime/viewer/headless.h"

#include <ostream>

#include "runtime/gl/headless_context.h"
#include "runtime/viewer/png_file.h"
#include "runtime/viewer/scene.h"

namespace cairn::viewer {

Status run_headless(const Options& options, std::ostream& messages) {
  const Result<Size> size = parse_size(options.size);
  if (!size) return size.error();
  Result<gl::FrameLook> look = look_of(options);
  if (!look) return look.error();
  Result<gl::HeadlessContext> context = gl::HeadlessContext::create();
  if (!context) return context.error();
  Result<Scene> scene = Scene::open(options);
  if (!scene) return scene.error();

  ViewState view = start_view(scene->pack(), options.fov_deg, *size);
  if (!options.camera.empty()) {
    const Result<ViewState> asked = parse_camera(options.camera);
    if (!asked) return asked.error();
    view = *asked;
  }
  view.fov_y_deg = options.fov_deg;
  view.viewport_width_px = size->width;
  view.viewport_height_px = size->height;
  look->to_sun = sun_direction(view.eye, options.hour);

  const Result<gl::FrameTarget> target = gl::FrameTarget::create(size->width, size->height);
  if (!target) return target.error();
  scene->load_all(view);
  scene->draw(view, 0, *look, target->framebuffer());
  for (const Error& error : scene->take_errors()) messages << error.message << '\n';
  return write_png(options.screenshot, target->read());
}

}  // namespace cairn::viewer
