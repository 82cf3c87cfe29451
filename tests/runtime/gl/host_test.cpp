// GlTerrain in a host's context: what the host has set does not show, and is as it was afterwards.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <epoxy/gl.h>
#include <glm/gtc/matrix_transform.hpp>

#include "cairn/gl_terrain.h"
#include "runtime/gl/frame_target.h"
#include "runtime/gl/gl_handle.h"
#include "runtime/gl/headless_context.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// Values of OpenGL's state that a host may depend on.
std::vector<double> state_of_context() {
  std::vector<double> values;
  for (const GLenum name : {GL_BLEND,
                            GL_CULL_FACE,
                            GL_DEPTH_TEST,
                            GL_DEPTH_CLAMP,
                            GL_STENCIL_TEST,
                            GL_SCISSOR_TEST,
                            GL_FRAMEBUFFER_SRGB,
                            GL_RASTERIZER_DISCARD,
                            GL_POLYGON_OFFSET_FILL,
                            GL_COLOR_LOGIC_OP,
                            GL_SAMPLE_ALPHA_TO_COVERAGE,
                            GL_SAMPLE_MASK,
                            GL_PRIMITIVE_RESTART,
                            GL_CLIP_DISTANCE0,
                            GL_CLIP_DISTANCE3,
                            GL_DEPTH_FUNC,
                            GL_DEPTH_WRITEMASK,
                            GL_CLIP_ORIGIN,
                            GL_CLIP_DEPTH_MODE,
                            GL_CURRENT_PROGRAM,
                            GL_VERTEX_ARRAY_BINDING,
                            GL_ARRAY_BUFFER_BINDING,
                            GL_DRAW_INDIRECT_BUFFER_BINDING,
                            GL_PIXEL_UNPACK_BUFFER_BINDING,
                            GL_SHADER_STORAGE_BUFFER_BINDING,
                            GL_DRAW_FRAMEBUFFER_BINDING,
                            GL_READ_FRAMEBUFFER_BINDING,
                            GL_ACTIVE_TEXTURE,
                            GL_UNPACK_ALIGNMENT,
                            GL_UNPACK_ROW_LENGTH,
                            GL_UNPACK_SKIP_ROWS,
                            GL_UNPACK_SWAP_BYTES,
                            GL_PACK_ALIGNMENT,
                            GL_PROGRAM_PIPELINE_BINDING}) {
    GLdouble value = 0;
    glGetDoublev(name, &value);
    values.push_back(value);
  }
  std::array<GLdouble, 4> four{};
  for (const GLenum name :
       {GL_VIEWPORT, GL_DEPTH_RANGE, GL_COLOR_WRITEMASK, GL_COLOR_CLEAR_VALUE, GL_SCISSOR_BOX}) {
    four = {};
    glGetDoublev(name, four.data());
    values.insert(values.end(), four.begin(), four.end());
  }
  for (GLuint unit = 0; unit < 8; ++unit) {
    GLint texture = 0, sampler = 0, flat = 0;
    glGetIntegeri_v(GL_TEXTURE_BINDING_2D_ARRAY, unit, &texture);
    glGetIntegeri_v(GL_TEXTURE_BINDING_2D, unit, &flat);
    glGetIntegeri_v(GL_SAMPLER_BINDING, unit, &sampler);
    values.insert(values.end(), {double(texture), double(flat), double(sampler)});
  }
  GLint storage = 0;
  glGetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, 0, &storage);
  values.push_back(storage);
  return values;
}

/// What a host may have set before it lets terrain draw.
std::vector<std::pair<std::string, std::function<void()>>> host_states() {
  return {
      {"blending",
       [] {
         glEnable(GL_BLEND);
         glBlendFunc(GL_ZERO, GL_ONE);
       }},
      {"depth mask off", [] { glDepthMask(GL_FALSE); }},
      {"colour mask", [] { glColorMask(GL_TRUE, GL_FALSE, GL_FALSE, GL_FALSE); }},
      {"scissor",
       [] {
         glEnable(GL_SCISSOR_TEST);
         glScissor(0, 0, 10, 10);
       }},
      {"rasterizer discard", [] { glEnable(GL_RASTERIZER_DISCARD); }},
      {"unpack row length",
       [] {
         glPixelStorei(GL_UNPACK_ROW_LENGTH, 3000);
         glPixelStorei(GL_UNPACK_SKIP_ROWS, 5);
       }},
      {"pixel unpack buffer",
       [] {
         GLuint buffer = 0;
         glGenBuffers(1, &buffer);
         glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
         glBufferData(GL_PIXEL_UNPACK_BUFFER, 16, nullptr, GL_STATIC_DRAW);
       }},
      {"stencil",
       [] {
         glEnable(GL_STENCIL_TEST);
         glStencilFunc(GL_NEVER, 1, 255);
       }},
      {"samplers and textures",
       [] {
         std::array<GLuint, 5> samplers{}, textures{};
         glGenSamplers(5, samplers.data());
         glCreateTextures(GL_TEXTURE_2D_ARRAY, 5, textures.data());
         for (GLuint i = 0; i < 5; ++i) {
           glSamplerParameteri(samplers[i], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
           glSamplerParameteri(samplers[i], GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
           glBindSampler(i, samplers[i]);
           glBindTextureUnit(i, textures[i]);
         }
         glActiveTexture(GL_TEXTURE3);
       }},
      {"culling, clip control, depth, lines, logic",
       [] {
         glEnable(GL_CULL_FACE);
         glCullFace(GL_FRONT_AND_BACK);
         glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
         glDepthFunc(GL_NEVER);
         glDepthRange(1, 0);
         glEnable(GL_CLIP_DISTANCE3);
         glPolygonMode(GL_FRONT_AND_BACK, GL_POINT);
         glEnable(GL_COLOR_LOGIC_OP);
         glLogicOp(GL_CLEAR);
         glEnable(GL_PRIMITIVE_RESTART);
         glPrimitiveRestartIndex(1);
         glViewport(3, 3, 7, 7);
         glEnable(GL_SAMPLE_MASK);
         glSampleMaski(0, 0);
       }},
  };
}

std::shared_ptr<const PackReader> open_pack(const std::filesystem::path& path) {
  Result<PackReader> reader = PackReader::open(path);
  REQUIRE(reader.ok());
  return std::make_shared<const PackReader>(std::move(*reader));
}

ViewState host_view() {
  ViewState view = view_at(ridge_places()[0], 6000, 30, -20);
  view.viewport_width_px = kWidth;
  view.viewport_height_px = kHeight;
  return view;
}

GlTerrain loaded(const std::filesystem::path& path, const ViewState& view) {
  Result<GlTerrain> terrain = GlTerrain::create(open_pack(path));
  if (!terrain) FAIL(terrain.error().message);
  while (!terrain->update(view, 0).is_settled) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  terrain->cut();
  terrain->update(view, 0);
  return std::move(*terrain);
}

void clear(const gl::FrameTarget& target) {
  const std::array<float, 4> black{};
  const float farthest = 0;
  glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, black.data());
  glClearNamedFramebufferfv(target.framebuffer(), GL_DEPTH, 0, &farthest);
}

GlTarget whole(const gl::FrameTarget& target) {
  return {target.framebuffer(), 0, 0, target.width(), target.height()};
}

/// Pixels that differ by more than rounding.
std::size_t different(const gl::Picture& a, const gl::Picture& b) {
  REQUIRE(a.rgb.size() == b.rgb.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) count += std::abs(int(a.rgb[i]) - int(b.rgb[i])) > 2;
  return count;
}

}  // namespace

TEST_CASE("ten states of a host do not show in the picture, and are as they were after it") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  const ViewState view = host_view();
  GlLook look;
  look.to_sun = glm::normalize(camera_frame(view).position);
  gl::Picture expected;
  {
    const auto context = gl::HeadlessContext::create();
    REQUIRE(context.ok());
    const auto target = gl::FrameTarget::create(kWidth, kHeight);
    REQUIRE(target.ok());
    GlTerrain terrain = loaded(dir.path() / "a.cairn", view);
    clear(*target);
    const GlCounts counts = terrain.draw(look, whole(*target));
    CHECK(counts.triangles > 100);
    expected = target->read();
  }
  for (const auto& [name, set] : host_states()) {
    CAPTURE(name);
    const auto own = gl::HeadlessContext::create();
    REQUIRE(own.ok());
    const auto picture = gl::FrameTarget::create(kWidth, kHeight);
    REQUIRE(picture.ok());
    clear(*picture);
    set();
    const std::vector<double> before = state_of_context();
    GlTerrain terrain = loaded(dir.path() / "a.cairn", view);
    terrain.draw(look, whole(*picture));
    CHECK(state_of_context() == before);
    CHECK(terrain.take_errors().empty());
    CHECK(glGetError() == GL_NO_ERROR);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    CHECK(different(picture->read(), expected) == 0);
  }
}

TEST_CASE("an off-centre projection shows the part of the picture that it is of, in a part of the target") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  const auto context = gl::HeadlessContext::create();
  REQUIRE(context.ok());
  const auto target = gl::FrameTarget::create(kWidth, kHeight);
  REQUIRE(target.ok());
  const ViewState view = host_view();
  GlTerrain terrain = loaded(dir.path() / "a.cairn", view);
  GlLook look;
  look.to_sun = glm::normalize(camera_frame(view).position);
  clear(*target);
  terrain.draw(look, whole(*target));
  const gl::Picture expected = target->read();
  // The two halves, each with a projection of its own, side by side.
  clear(*target);
  for (const int half : {0, 1}) {
    const glm::dmat4 stretched =
        glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(half == 0 ? 1 : -1, 0, 0)), glm::dvec3(2, 1, 1));
    terrain.draw(look, {target->framebuffer(), half * kWidth / 2, 0, kWidth / 2, kHeight},
                 stretched * clip_from_eye(view));
  }
  // A pixel's middle is hit the same way but for rounding: at the edges of triangles a few differ.
  CHECK(different(target->read(), expected) < expected.rgb.size() / 100);
}

TEST_CASE("a depth pass writes the picture's depth and no colour; usual depth gives the same picture") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  const auto context = gl::HeadlessContext::create();
  REQUIRE(context.ok());
  const auto target = gl::FrameTarget::create(kWidth, kHeight);
  REQUIRE(target.ok());
  const ViewState view = host_view();
  GlTerrain terrain = loaded(dir.path() / "a.cairn", view);
  GlLook look;
  look.to_sun = glm::normalize(camera_frame(view).position);
  look.sky = false;
  clear(*target);
  terrain.draw(look, whole(*target));
  const gl::Picture picture = target->read();
  const std::vector<float> depth = target->read_depth();
  clear(*target);
  look.depth_only = true;
  terrain.draw(look, whole(*target));
  CHECK(target->read_depth() == depth);
  const gl::Picture none = target->read();
  CHECK(std::all_of(none.rgb.begin(), none.rgb.end(), [](auto c) { return c == 0; }));

  look.depth_only = false;
  clear(*target);
  const float farthest = 1;
  glClearNamedFramebufferfv(target->framebuffer(), GL_DEPTH, 0, &farthest);
  GlTarget usual = whole(*target);
  usual.reversed_depth = false;
  const CameraFrame camera = camera_frame(view);
  const glm::dmat4 projection =
      glm::perspective(glm::radians(view.fov_y_deg), double(kWidth) / kHeight, 10.0, 1e6) *
      glm::lookAt(glm::dvec3(0), camera.forward, camera.up);
  terrain.draw(look, usual, projection);
  CHECK(different(target->read(), picture) < picture.rgb.size() / 100);
}

TEST_CASE("several samples a pixel and an orthographic projection are drawn") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  const auto context = gl::HeadlessContext::create();
  REQUIRE(context.ok());
  const auto target = gl::FrameTarget::create(kWidth, kHeight);
  REQUIRE(target.ok());
  const ViewState view = host_view();
  GlTerrain terrain = loaded(dir.path() / "a.cairn", view);
  GlLook look;
  look.to_sun = glm::normalize(camera_frame(view).position);
  clear(*target);
  terrain.draw(look, whole(*target));
  const gl::Picture expected = target->read();

  gl::Texture colour = gl::make_texture(GL_TEXTURE_2D_MULTISAMPLE),
              depth = gl::make_texture(GL_TEXTURE_2D_MULTISAMPLE);
  glTextureStorage2DMultisample(colour.name(), 4, GL_SRGB8_ALPHA8, kWidth, kHeight, GL_TRUE);
  glTextureStorage2DMultisample(depth.name(), 4, GL_DEPTH_COMPONENT32F, kWidth, kHeight, GL_TRUE);
  const gl::Framebuffer samples = gl::make_framebuffer();
  glNamedFramebufferTexture(samples.name(), GL_COLOR_ATTACHMENT0, colour.name(), 0);
  glNamedFramebufferTexture(samples.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
  REQUIRE(glCheckNamedFramebufferStatus(samples.name(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
  const std::array<float, 4> black{};
  const float farthest = 0;
  glClearNamedFramebufferfv(samples.name(), GL_COLOR, 0, black.data());
  glClearNamedFramebufferfv(samples.name(), GL_DEPTH, 0, &farthest);
  terrain.draw(look, {samples.name(), 0, 0, kWidth, kHeight});
  glBlitNamedFramebuffer(samples.name(), target->framebuffer(), 0, 0, kWidth, kHeight, 0, 0, kWidth, kHeight,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  const gl::Picture smooth = target->read();
  double sum = 0;
  for (std::size_t i = 0; i < smooth.rgb.size(); ++i)
    sum += std::abs(int(smooth.rgb[i]) - int(expected.rgb[i]));
  CHECK(sum / static_cast<double>(smooth.rgb.size()) < 4);

  // Straight down on ten kilometres: no perspective, so that all of it is ground.
  clear(*target);
  look.sky = false;
  look.fog = false;
  GlTarget usual = whole(*target);
  usual.reversed_depth = false;
  glClearNamedFramebufferfv(target->framebuffer(), GL_DEPTH, 0, std::array{1.0F}.data());
  ViewState down = view;
  down.pitch_deg = -90;
  down.height_m = 30000;
  down.fov_y_deg = 60;
  terrain.cut();
  while (!terrain.update(down, 0).is_settled) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const CameraFrame camera = camera_frame(down);
  terrain.draw(look, usual,
               glm::ortho(-5000.0, 5000.0, -5000.0, 5000.0, 10.0, 60000.0) *
                   glm::lookAt(glm::dvec3(0), camera.forward, camera.up));
  const gl::Picture map = target->read();
  std::size_t bare = 0;
  for (std::size_t i = 0; i < map.rgb.size(); i += 3)
    bare += map.rgb[i] + map.rgb[i + 1] + map.rgb[i + 2] == 0;
  CHECK(bare == 0);
  CHECK(glGetError() == GL_NO_ERROR);
}

}  // namespace cairn::test
