#include "runtime/gl/renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include "runtime/gl/gpu_timer.h"
#include "runtime/gl/host_state.h"
#include "runtime/gl/loose_batch.h"
#include "runtime/gl/object_batch.h"
#include "runtime/gl/patch_batch.h"
#include "runtime/gl/patch_records.h"
#include "runtime/gl/resident_tiles.h"
#include "runtime/gl/shader_program.h"
#include "runtime/gl/view_transform.h"
#include "runtime/surface/drape_index.h"

namespace cairn::gl {
namespace {

enum Location : GLint {
  kEyeHigh = 0,
  kClip = 1,
  kCells = 2,
  kEyeFloat = 3,
  kSun = 4,
  kEyeHeight = 5,
  kLook = 6,
  kQuantum = 7,
  kHorizon = 8,
  kEyeLow = 9,
  kLowest = 10,
  kRadii = 11,
  kSea = 12,
  kContours = 13,
  kExposure = 14,
  kImagery = 15,
  kTintCount = 16,
  kTintStops = 17
};
constexpr double kFarthestDepth = 1e-30;  // of ground: none is so far that its own would be as small
enum LookBits : GLuint {
  kLevelColours = 1,
  kFog = 2,
  kEarth = 4,
  kDither = 8,
  kShadows = 16,
  kWater = 32,
  kSlopes = 64
};

}  // namespace

struct Renderer::State {
  State(int size, double quantum, std::size_t expected) : quantum_m(quantum), tiles(size, expected) {}

  double quantum_m;
  ResidentTiles tiles;
  PatchBatch patches;
  LooseBatch loose;
  ObjectBatch objects;
  Buffer records = make_buffer();
  Buffer segments = make_buffer();
  std::optional<DrapeIndex> drape;  // of the last picture that had one
  Program terrain;
  Program sky;
  Program object;
  VertexArray no_vertices = make_vertex_array();
  GpuTimer timer;

  void set_uniforms(const Camera& camera, const GlLook& look);
  void set_tint(const GlLook& look);
  void fill_records(const SurfaceFrame& frame, const SurfaceMesh& mesh, const ViewState& view,
                    const std::shared_ptr<const Drape>& drape);
  void draw_ground(const SurfaceMesh& mesh, const GlLook& look, bool calls);
  void draw_objects(const SurfaceObjects& shown, const Camera& camera, const GlLook& look, bool calls);
  void draw_sky(const Camera& camera, const GlTarget& target);
};

void Renderer::State::set_uniforms(const Camera& camera, const GlLook& look) {
  const GLuint program = terrain.name();
  const glm::dvec3 position = camera_frame(camera.view).position;
  const glm::mat4 clip(camera.clip_from_eye);
  const glm::vec3 eye_high(position), eye_low(position - glm::dvec3(eye_high));
  glProgramUniform3f(program, kEyeHigh, eye_high.x, eye_high.y, eye_high.z);
  glProgramUniform3f(program, kEyeLow, eye_low.x, eye_low.y, eye_low.z);
  glProgramUniformMatrix4fv(program, kClip, 1, GL_FALSE, glm::value_ptr(clip));
  glProgramUniform1ui(program, kCells, static_cast<GLuint>(tiles.cells_log2()));
  glProgramUniform1f(program, kQuantum, static_cast<float>(quantum_m));
  const glm::vec4 horizon(horizon_plane(position, camera.view.ellipsoid));
  glProgramUniform4f(program, kHorizon, horizon.x, horizon.y, horizon.z, horizon.w);
  glProgramUniform1f(sky.name(), kLowest, static_cast<float>(std::min(camera.lowest_m, 0.0)));
  const GLuint look_bits = (look.level_colours ? kLevelColours : 0u) |
                           (look.fog && look.is_earth ? kFog : 0u) | (look.is_earth ? kEarth : 0u) |
                           (look.dithers ? kDither : 0u) | (look.shadows ? kShadows : 0u) |
                           (look.sea_m && look.is_earth ? kWater : 0u) | (look.slope_colours ? kSlopes : 0u);
  glProgramUniform1f(program, kContours, static_cast<float>(look.contours_m));
  for (const GLuint each : {program, sky.name()}) {
    glProgramUniform1f(each, kSea, static_cast<float>(look.sea_m.value_or(0)));
  }
  set_tint(look);
  const auto a = static_cast<float>(camera.view.ellipsoid.semi_major_m);
  const auto b = static_cast<float>(camera.view.ellipsoid.semi_minor_m);
  for (const GLuint each : {program, sky.name(), object.name()}) {
    glProgramUniform3f(each, kRadii, a, a, b);
    const glm::vec3 sun(look.to_sun);
    glProgramUniform1f(each, kEyeHeight, static_cast<float>(camera.view.height_m));
    glProgramUniform1ui(each, kLook, look_bits);
    glProgramUniform1f(each, kExposure, static_cast<float>(std::exp2(look.exposure_ev)));
    glProgramUniform3f(each, kEyeFloat, eye_high.x, eye_high.y, eye_high.z);
    glProgramUniform3f(each, kSun, sun.x, sun.y, sun.z);
  }
}

void Renderer::State::set_tint(const GlLook& look) {
  static const std::vector<TintStop> kBareRock = {{-9000, glm::vec3(0.20f)}, {9000, glm::vec3(0.42f)}};
  const std::vector<TintStop>& stops = !look.tint.empty() ? look.tint
                                       : look.is_earth    ? tints().front().stops
                                                          : kBareRock;
  assert(stops.size() <= kMostTintStops);
  std::vector<glm::vec4> values;
  for (const TintStop& stop : stops) values.emplace_back(stop.colour, static_cast<float>(stop.height_m));
  glProgramUniform1i(terrain.name(), kTintCount, static_cast<GLint>(values.size()));
  glProgramUniform4fv(terrain.name(), kTintStops, static_cast<GLsizei>(values.size()),
                      glm::value_ptr(values.front()));
  glProgramUniform1f(terrain.name(), kImagery, static_cast<float>(look.imagery));
}

void Renderer::State::fill_records(const SurfaceFrame& frame, const SurfaceMesh& mesh, const ViewState& view,
                                   const std::shared_ptr<const Drape>& lines) {
  std::vector<PatchRecord> patch_facts = patch_records(mesh.draws, frame.tiles, tiles);
  std::vector<DrapedSegment> draped;
  if (lines) {
    if (!drape || &drape->drape() != lines.get()) drape.emplace(lines);
    draped = drape_on(mesh.draws, frame.tiles, view, *drape, patch_facts);
  } else {
    drape.reset();
  }
  fill<PatchRecord>(records, patch_facts);
  fill<DrapedSegment>(segments, draped);
}

void Renderer::State::draw_ground(const SurfaceMesh& mesh, const GlLook& look, bool calls) {
  // A triangle seen edge-on, as a wall may be, has no slope to reckon a pixel's depth by: what comes out may
  // be anything, and must not be that of the sky.
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_CLIP_DISTANCE0);
  glPolygonMode(GL_FRONT_AND_BACK, look.wireframe ? GL_LINE : GL_FILL);
  glUseProgram(terrain.name());
  tiles.bind();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, records.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, segments.name());
  patches.draw(mesh, calls);
  loose.draw(mesh.walls.vertices, mesh.walls.indices, calls);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_CLIP_DISTANCE0);
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::State::draw_objects(const SurfaceObjects& shown, const Camera& camera, const GlLook& look,
                                   bool calls) {
  const glm::mat4 clip(camera.clip_from_eye);
  glProgramUniformMatrix4fv(object.name(), kClip, 1, GL_FALSE, glm::value_ptr(clip));
  glEnable(GL_DEPTH_CLAMP);
  glPolygonMode(GL_FRONT_AND_BACK, look.wireframe ? GL_LINE : GL_FILL);
  glUseProgram(object.name());
  objects.draw(shown, object.name(), calls);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::State::draw_sky(const Camera& camera, const GlTarget& target) {
  // The rays to the points of the farthest plane; with these depths they lie infinitely far, or all as far.
  const double farthest = target.reversed_depth ? 0 : 1;
  glm::dmat4 rays = glm::inverse(camera.clip_from_eye);
  rays[3] += rays[2] * farthest;
  const glm::mat4 ray_from_clip(rays);
  glProgramUniformMatrix4fv(sky.name(), 0, 1, GL_FALSE, glm::value_ptr(ray_from_clip));
  glUseProgram(sky.name());
  glBindVertexArray(no_vertices.name());
  glDepthFunc(GL_EQUAL);  // only where nothing was drawn
  glDepthRangeIndexed(0, farthest, farthest);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(int tile_size, double quantum_m, std::size_t expected_tiles) {
  if (epoxy_gl_version() < 45) {
    return failed("OpenGL: context: expected version 4.5, found " + std::to_string(epoxy_gl_version() / 10) +
                  "." + std::to_string(epoxy_gl_version() % 10));
  }
  auto state = std::make_unique<State>(tile_size, quantum_m, expected_tiles);
  Result<Program> terrain = link_program("terrain");
  if (!terrain) return terrain.error();
  Result<Program> sky = link_program("sky");
  if (!sky) return sky.error();
  state->terrain = std::move(*terrain);
  state->sky = std::move(*sky);
  Result<Program> object = link_program("object");
  if (!object) return object.error();
  state->object = std::move(*object);
  return Renderer(std::move(state));
}

std::size_t Renderer::take(const SurfaceFrame& frame) {
  const HostState host;
  state_->tiles.begin_frame(frame);
  state_->patches.take(frame.mesh);
  state_->objects.take(frame.objects);
  for (const RenderTile* tile : frame.tiles) {
    if (tile->visible) state_->tiles.imagery_of(*tile);
  }
  return state_->tiles.uploads();
}

namespace {

void aim_at(const GlTarget& target, const GlLook& look) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
  glViewportIndexedf(0, static_cast<GLfloat>(target.x), static_cast<GLfloat>(target.y),
                     static_cast<GLfloat>(target.width_px), static_cast<GLfloat>(target.height_px));
  glClipControl(GL_LOWER_LEFT, target.reversed_depth ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
  if (target.is_srgb) glEnable(GL_FRAMEBUFFER_SRGB);
  // Faces are not culled: rounding may turn a sliver over, and it must be drawn all the same.
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(target.reversed_depth ? GL_GREATER : GL_LESS);
  if (target.reversed_depth) {
    glDepthRangeIndexed(0, kFarthestDepth, 1);
  } else {
    glDepthRangeIndexed(0, 0, 1 - 1e-7);
  }
  if (look.depth_only) glColorMaski(0, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
}

}  // namespace

GlCounts Renderer::draw(const SurfaceFrame& frame, const SurfaceMesh& mesh, const Camera& camera,
                        const GlLook& look, const GlTarget& target, bool calls) {
  State& s = *state_;
  const HostState host;
  s.timer.begin();
  s.fill_records(frame, mesh, camera.view, look.drape);
  s.set_uniforms(camera, look);
  aim_at(target, look);
  s.draw_ground(mesh, look, calls);
  if (look.objects) s.draw_objects(frame.objects, camera, look, calls);
  if (look.sky && !look.depth_only && calls) s.draw_sky(camera, target);
  s.timer.end();
  GlCounts counts{mesh.draws.size(), mesh.triangles, 0,
                  s.tiles.bytes() + s.patches.bytes() + s.objects.bytes(), s.timer.ms()};
  if (look.objects) {
    counts.objects = frame.objects.objects;
    counts.billboards = frame.objects.billboards;
    counts.object_calls = frame.objects.draws.size();
    counts.object_triangles = static_cast<std::size_t>(frame.objects.triangles);
  }
  return counts;
}

std::size_t Renderer::update_shadows(SunShadows& shadows, const SurfaceFrame& frame, const SurfaceMesh& mesh,
                                     const glm::dvec3& to_sun) {
  // A step of the sun that moves the end of a shadow by a thousandth of its length at a height of 45°.
  constexpr double kSameSun = 5e-4;
  const HostState host;
  for (const TileShadow& shadow : shadows.take()) state_->tiles.set_shadow(shadow);
  // Several patches show one tile, and several tiles one ancestor's heights.
  std::vector<bool> known(frame.tiles.size());
  std::vector<const RenderTile*> late;
  for (const SurfaceDraw& draw : mesh.draws) {
    const RenderTile* tile = frame.tiles[draw.tile];
    if (known[draw.tile] || !tile->heights || !tile->visible) continue;
    known[draw.tile] = true;
    const ResidentHeights* resident = state_->tiles.heights_of(*tile);
    if (!resident) continue;
    if (resident->shadow_sun && glm::distance(*resident->shadow_sun, to_sun) < kSameSun) continue;
    late.push_back(tile);
  }
  std::sort(late.begin(), late.end(), [](const RenderTile* a, const RenderTile* b) {
    return std::pair(a->distance_m, a->heights_id) < std::pair(b->distance_m, b->heights_id);
  });
  std::unordered_set<TileId> seen;
  std::vector<ShadowRequest> due;
  for (const RenderTile* tile : late) {
    if (seen.insert(tile->heights_id).second) due.push_back({tile->heights_id, tile->heights, to_sun});
  }
  const std::size_t count = due.size();
  shadows.request(std::move(due));
  return count;
}

std::vector<Error> Renderer::take_errors() {
  return state_->tiles.take_errors();
}

void clear(const GlTarget& target, const glm::vec3& colour) {
  const HostState host;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
  if (target.is_srgb) glEnable(GL_FRAMEBUFFER_SRGB);
  const GLfloat values[] = {colour.r, colour.g, colour.b, 1};
  const GLfloat farthest = target.reversed_depth ? 0 : 1;
  glClearBufferfv(GL_COLOR, 0, values);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

}  // namespace cairn::gl
