#include "runtime/gl/renderer.h"

#include <algorithm>
#include <string>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "runtime/gl/axis_buffer.h"
#include "runtime/gl/grid_batch.h"
#include "runtime/gl/method_batch.h"
#include "runtime/gl/method_scene.h"
#include "runtime/gl/patch_records.h"
#include "runtime/gl/resident_tiles.h"
#include "runtime/gl/shader_program.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/gl/wall_batch.h"
#include "runtime/surface/drawn_ground.h"
#include "runtime/surface/lod_transition.h"
#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {
namespace {

enum Location : GLint {
  kEye = 0,
  kClip = 1,
  kCells = 2,
  kEyeFloat = 3,
  kSun = 4,
  kEyeHeight = 5,
  kLook = 6,
  kQuantum = 7,
  kHorizon = 8,
  kVertexKind = 9,
  kLowest = 10
};
enum VertexKind : GLuint { kOfGrid = 0, kOfMethod = 1, kOfWall = 2 };
constexpr double kLongestFade_s = 2;      // that the exchange of a level takes at most
constexpr float kFarthestDepth = 1e-30f;  // no terrain is so far that its own would be as small
enum LookBits : GLuint { kLevelColours = 1, kFog = 2 };

}  // namespace

struct Renderer::State {
  State(int size, double quantum, std::size_t expected, PreparedHeights& uploads)
      : quantum_m(quantum), tiles(size, quantum, expected, uploads), columns(size), rows(size) {}

  double quantum_m;
  LodTransition shown;
  ResidentTiles tiles;
  ColumnBuffer columns;
  RowBuffer rows;
  GridBatch grids;
  WallBatch walls;
  MethodBatch method_batch;
  const LodMethodInfo* method_info = nullptr;  // of the method, which is kept from frame to frame
  std::unique_ptr<LodMethod> method;
  Program terrain;
  Program sky;
  VertexArray no_vertices = make_vertex_array();

  LodTransition::SurfaceOf surfaces();
  std::vector<const ShownTile*> load_visible(const RenderList& list, const FrameScale& scale);
  MeshPlan plan(std::span<const ShownTile* const> seen, const ViewState& view, const FrameScale& scale,
                const CameraFrame& camera);
  LodMesh method_mesh(const LodMethodInfo& info, const LodScene& scene, const ViewState& view,
                      double tolerance_px);
  void set_uniforms(const CameraFrame& camera, const ViewState& view, const FrameLook& look, double lowest_m);
  void draw_sky(const CameraFrame& camera, const ViewState& view);
};

LodTransition::SurfaceOf Renderer::State::surfaces() {
  return [this](const RenderTile& tile) {
    const ResidentHeights* heights = tiles.heights_of(tile);
    return heights ? &heights->surface : nullptr;
  };
}

std::vector<const ShownTile*> Renderer::State::load_visible(const RenderList& list, const FrameScale& scale) {
  shown.update(list, scale, surfaces());
  tiles.begin_frame(list.evicted, shown.tiles());
  std::vector<const ShownTile*> seen;
  for (const ShownTile& each : shown.tiles()) {
    // Where there are no heights, what ends there may be seen though the ground is not: its walls are drawn
    // with it.
    if (!each.tile.visible && each.tile.heights) continue;
    tiles.heights_of(each.tile);
    if (each.tile.visible) tiles.imagery_of(each.tile);
    seen.push_back(&each);
  }
  return seen;
}

MeshPlan Renderer::State::plan(std::span<const ShownTile* const> seen, const ViewState& view,
                               const FrameScale& scale, const CameraFrame& camera) {
  std::vector<MeshArea> areas;
  for (const ShownTile* each : seen) {
    const ResidentHeights* heights = tiles.heights_of(each->tile);
    areas.push_back({each->tile.area, heights ? &heights->surface : nullptr, each->tile.distance_m,
                     each->detail, each->moves});
  }
  MeshRules rules;
  rules.tile_size = tiles.tile_size();
  rules.pixels_per_radian = scale.pixels_per_radian;
  rules.tolerance_px = scale.tolerance_px;
  rules.eye = scale.eye;
  const auto inward = inward_normals(camera, view);
  rules.inward.assign(inward.begin(), inward.end());
  return plan_mesh(areas, rules);
}

LodMesh Renderer::State::method_mesh(const LodMethodInfo& info, const LodScene& scene, const ViewState& view,
                                     double tolerance_px) {
  if (method_info != &info) {
    method_info = &info;
    method = info.create({});
  }
  method->prepare(scene);
  return method->build(scene, {view, tolerance_px, true});
}

void Renderer::State::set_uniforms(const CameraFrame& camera, const ViewState& view, const FrameLook& look,
                                   double lowest_m) {
  const GLuint program = terrain.name();
  const glm::mat4 clip(clip_from_eye(camera, view));
  glProgramUniform3d(program, kEye, camera.position.x, camera.position.y, camera.position.z);
  glProgramUniformMatrix4fv(program, kClip, 1, GL_FALSE, glm::value_ptr(clip));
  glProgramUniform1ui(program, kCells, static_cast<GLuint>(cells_log2_of(tiles.tile_size())));
  glProgramUniform1f(program, kQuantum, static_cast<float>(quantum_m));
  const glm::vec4 horizon(horizon_plane(camera.position));
  glProgramUniform4f(program, kHorizon, horizon.x, horizon.y, horizon.z, horizon.w);
  glProgramUniform1f(sky.name(), kLowest, static_cast<float>(std::min(lowest_m, 0.0)));
  for (const GLuint each : {program, sky.name()}) {
    const glm::vec3 eye(camera.position), sun(look.to_sun);
    glProgramUniform1f(each, kEyeHeight, static_cast<float>(view.height_m));
    glProgramUniform1ui(each, kLook, (look.level_colours ? kLevelColours : 0u) | (look.fog ? kFog : 0u));
    glProgramUniform3f(each, kEyeFloat, eye.x, eye.y, eye.z);
    glProgramUniform3f(each, kSun, sun.x, sun.y, sun.z);
  }
}

void Renderer::State::draw_sky(const CameraFrame& camera, const ViewState& view) {
  const glm::mat4 rays = ray_from_clip(camera, view);
  glProgramUniformMatrix4fv(sky.name(), 0, 1, GL_FALSE, glm::value_ptr(rays));
  glUseProgram(sky.name());
  glBindVertexArray(no_vertices.name());
  glDepthFunc(GL_EQUAL);  // only where nothing was drawn
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(int tile_size, double quantum_m, std::size_t expected_tiles,
                                  PreparedHeights& uploads) {
  if (epoxy_gl_version() < 45) {
    return failed("OpenGL: context: expected version 4.5, found " + std::to_string(epoxy_gl_version() / 10) +
                  "." + std::to_string(epoxy_gl_version() % 10));
  }
  auto state = std::make_unique<State>(tile_size, quantum_m, expected_tiles, uploads);
  Result<Program> terrain = link_program("terrain");
  if (!terrain) return terrain.error();
  Result<Program> sky = link_program("sky");
  if (!sky) return sky.error();
  state->terrain = std::move(*terrain);
  state->sky = std::move(*sky);
  return Renderer(std::move(state));
}

namespace {

void begin_picture(const ViewState& view, const FrameLook& look, unsigned framebuffer) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, view.viewport_width_px, view.viewport_height_px);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);  // rounding may turn a sliver over; it must be drawn all the same
  glDepthFunc(GL_GREATER);
  // A triangle seen edge-on, as a wall may be, has no slope to reckon a pixel's depth by: what comes out may
  // be anything, and must not be that of the sky.
  glEnable(GL_DEPTH_CLAMP);
  glDepthRangef(kFarthestDepth, 1);
  const glm::vec3 background = look.hole_colour.value_or(glm::vec3(0));
  glClearColor(background.r, background.g, background.b, 1);
  glClearDepth(0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

}  // namespace

FrameCounts Renderer::draw(const RenderList& list, const ViewState& view, const FrameLook& look,
                           unsigned framebuffer) {
  State& s = *state_;
  FrameCounts counts;
  // 1. What is seen, uploaded where it was not.
  const double begin_s = thread_cpu_s();
  const CameraFrame camera = camera_frame(view);
  FrameScale scale{camera.position, 1 / pixel_footprint_m(view, 1), look.tolerance_px};
  if (look.frame_s > 0) scale.longest_fade = std::max(1.0, kLongestFade_s / look.frame_s);
  s.columns.begin_frame();
  s.rows.begin_frame();
  if (look.method) s.shown.cut();
  const std::vector<const ShownTile*> seen = s.load_visible(list, scale);
  counts.uploads = s.tiles.uploads();
  counts.upload_ms = 1e3 * (thread_cpu_s() - begin_s);
  // 2. The grids, or a method's mesh, and what they show.
  LodMesh mesh;
  MethodScene scene;
  MeshPlan plan;
  if (look.method) {
    scene = method_scene(seen, s.surfaces(), s.tiles.tile_size(), s.quantum_m);
    mesh = s.method_mesh(*look.method, scene.scene, view, look.tolerance_px);
  } else {
    s.method_info = nullptr;
    s.method.reset();
    plan = s.plan(seen, view, scale, camera);
  }
  const std::vector<PatchRecord> records =
      patch_records(look.method ? scene.windows : plan, seen, s.tiles, s.columns, s.rows);
  counts.patches = records.size();
  // 3. Draw: terrain, then the sky where nothing is.
  s.set_uniforms(camera, view, look, list.lowest_m);
  begin_picture(view, look, framebuffer);
  glEnable(GL_CLIP_DISTANCE0);
  glEnable(GL_CLIP_DISTANCE1);
  glPolygonMode(GL_FRONT_AND_BACK, look.wireframe ? GL_LINE : GL_FILL);
  glUseProgram(s.terrain.name());
  s.tiles.bind();
  if (look.method) {
    glProgramUniform1ui(s.terrain.name(), kVertexKind, kOfMethod);
    counts.triangles = s.method_batch.draw(mesh, scene.scene, records, camera.position, look.draws);
  } else if (!records.empty()) {
    glProgramUniform1ui(s.terrain.name(), kVertexKind, kOfGrid);
    counts.triangles = s.grids.draw(records, plan.perimeter, s.columns, s.rows, look.draws);
    glProgramUniform1ui(s.terrain.name(), kVertexKind, kOfWall);
    counts.triangles += s.walls.draw(plan, look.draws);
  }
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_CLIP_DISTANCE0);
  glDisable(GL_CLIP_DISTANCE1);
  glDisable(GL_DEPTH_CLAMP);
  glDepthRangef(0, 1);
  if (!look.hole_colour && look.draws) s.draw_sky(camera, view);
  counts.gpu_bytes = s.tiles.bytes() + s.columns.bytes() + s.rows.bytes();
  return counts;
}

void Renderer::cut() {
  state_->shown.cut();
}

std::optional<double> Renderer::ground_m(LonLat place) const {
  return drawn_ground_m(state_->shown.tiles(), state_->quantum_m, place);
}

std::vector<Error> Renderer::take_errors() {
  return state_->tiles.take_errors();
}

}  // namespace cairn::gl
