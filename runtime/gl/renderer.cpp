#include "runtime/gl/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "runtime/geodesy.h"
#include "runtime/gl/axis_buffer.h"
#include "runtime/gl/grid_indices.h"
#include "runtime/gl/mesh_plan.h"
#include "runtime/gl/shader_program.h"
#include "runtime/gl/tile_textures.h"

namespace cairn::gl {
namespace {

/// As terrain.vert declares them.
struct PatchRecord {
  std::uint32_t column_table = 0;
  std::uint32_t row_table = 0;
  std::uint32_t cells_log2 = 0;
  std::uint32_t cells_east = 0;
  std::uint32_t cells_north = 0;
  std::uint32_t perimeter = 0;
  std::uint32_t listed_sides = 0;
  std::int32_t height_layer = -1;
  std::int32_t height_base = 0;
  std::int32_t height_shift = 0;
  float height_step = 0;
  std::int32_t imagery_array = 0;
  glm::vec2 height_origin{0};
  glm::vec2 imagery_origin{0};
  std::int32_t imagery_layer = 0;
  float imagery_scale = 1;
  std::int32_t level = 0;
  std::int32_t unused = 0;  // GLSL rounds the size up to a multiple of 8
};
static_assert(sizeof(PatchRecord) == 80 && offsetof(PatchRecord, height_origin) == 48);
static_assert(sizeof(PerimeterVertex) == 8);

enum Location : GLint {
  kEye = 0,
  kClip = 1,
  kCells = 2,
  kEyeFloat = 3,
  kSun = 4,
  kEyeHeight = 5,
  kLook = 6,
  kQuantum = 7,
  kHorizon = 8
};
enum LookBits : GLuint { kLevelColours = 1, kFog = 2 };

/// From metres relative to the eye, along the Earth's axes, to clip space; depth is near / distance: 1 at the
/// near plane, 0 infinitely far.
glm::dmat4 clip_from_eye(const CameraFrame& camera, const ViewState& view) {
  const double f = 1 / std::tan(glm::radians(view.fov_y_deg) / 2);
  const double aspect = static_cast<double>(view.viewport_width_px) / view.viewport_height_px;
  const glm::dvec3 right = camera.right * (f / aspect), up = camera.up * f;
  const glm::dmat4 rows{glm::dvec4(right, 0), glm::dvec4(up, 0), glm::dvec4(0, 0, 0, kNear_m),
                        glm::dvec4(camera.forward, 0)};
  return glm::transpose(rows);
}

/// Normals of the planes through the eye and the picture's sides, and of the one that parts before from
/// behind.
std::vector<glm::dvec3> inward_normals(const CameraFrame& camera, const ViewState& view) {
  const double top = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double side = top * view.viewport_width_px / view.viewport_height_px;
  return {glm::normalize(camera.forward * side + camera.right),
          glm::normalize(camera.forward * side - camera.right),
          glm::normalize(camera.forward * top + camera.up), glm::normalize(camera.forward * top - camera.up),
          camera.forward};
}

/// Rays from the eye through the corners of the picture, as a matrix on clip coordinates.
glm::mat4 ray_from_clip(const CameraFrame& camera, const ViewState& view) {
  const double t = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double aspect = static_cast<double>(view.viewport_width_px) / view.viewport_height_px;
  return glm::mat4(glm::dmat4{glm::dvec4(camera.right * (t * aspect), 0), glm::dvec4(camera.up * t, 0),
                              glm::dvec4(0), glm::dvec4(camera.forward, 0)});
}

/// A plane, for positions relative to the eye, that all the ground before the horizon lies inside of, and
/// most of the Earth's far side outside: a hole in the ground must not show the inside of the antipodes.
///
/// Scaled so that an ellipsoid below all ground is the unit sphere, the eye at distance m > 1 sees the sphere
/// up to the plane 1/m along its own direction; ground of radius r behind the sphere's horizon up to 1/m -
/// sqrt(1 - 1/m²)·sqrt(r² - 1).
glm::dvec4 horizon_plane(const glm::dvec3& eye) {
  constexpr double kDeepest = 12000, kHighest = 10000;  // no ground is lower, higher
  const glm::dvec3 radii = glm::dvec3(kEquatorialRadius, kEquatorialRadius, kPolarRadius) - kDeepest;
  const glm::dvec3 scaled = eye / radii;
  const double m = glm::length(scaled);
  if (m <= 1) return {0, 0, 0, 1};
  const double r = (kPolarRadius + kHighest) / radii.z;
  const double seen = 1 / m - std::sqrt(1 - 1 / (m * m)) * std::sqrt(r * r - 1);
  return {scaled / m / radii, m - seen};
}

/// Where the south-west corner of an area lies in a tile that covers it, 0…1, and the area's share of a side.
struct Window {
  double x = 0;
  double y = 0;
  double scale = 1;
};
Window window_in(const TileId& tile, const TileId& area) {
  const LatticePoint a = south_west_of(area), t = south_west_of(tile);
  const auto width = static_cast<double>(lattice_width(tile.level));
  return {static_cast<double>(a.x - t.x) / width, static_cast<double>(a.y - t.y) / width,
          std::ldexp(1.0, tile.level - area.level)};
}

/// A tile of heights that has been uploaded.
struct Surface {
  SurfaceTile tile;
  std::int32_t base = 0;
  int shift = 0;
};

}  // namespace

struct Renderer::State {
  State(int size, double quantum, HeightUploads& source)
      : tile_size(size),
        quantum_m(quantum),
        uploads(source),
        heights(size),
        imagery{ImageryTextures(TextureFormat::bc1, size - 1), ImageryTextures(TextureFormat::bc3, size - 1),
                ImageryTextures(TextureFormat::bc7, size - 1)},
        columns(size),
        rows(size) {}

  int tile_size;
  double quantum_m;
  HeightUploads& uploads;
  Program terrain;
  Program sky;
  VertexArray vertex_array;
  Buffer patch_buffer = make_buffer();
  Buffer perimeter_buffer = make_buffer();
  Buffer instance_buffer = make_buffer();
  GridIndices indices;
  HeightTextures heights;
  std::array<ImageryTextures, 3> imagery;
  ColumnBuffer columns;
  RowBuffer rows;
  std::unordered_map<TileId, Surface> surfaces;
  std::array<bool, 3> refused{};
  std::vector<Error> errors;
  FrameCounts counts;

  void begin_frame(const RenderList& list);
  const Surface* surface_of(const RenderTile& tile);
  int imagery_array_of(const RenderTile& tile);
  void show_heights(const RenderTile& tile, const GridPatch& grid, PatchRecord& record);
  void show_imagery(const RenderTile& tile, const GridPatch& grid, PatchRecord& record);
  std::vector<PatchRecord> records_of(const MeshPlan& plan, std::span<const RenderTile* const> tiles);
  MeshPlan plan(std::span<const RenderTile* const> tiles, const ViewState& view, const FrameLook& look,
                const CameraFrame& camera);
  void set_uniforms(const CameraFrame& camera, const ViewState& view, const FrameLook& look);
  void draw_patches(const MeshPlan& plan, const std::vector<PatchRecord>& records);
  void draw_sky(const CameraFrame& camera, const ViewState& view, const FrameLook& look);
};

void Renderer::State::begin_frame(const RenderList& list) {
  counts = {};
  heights.begin_frame();
  for (ImageryTextures& array : imagery) array.begin_frame();
  columns.begin_frame();
  rows.begin_frame();
  for (const TileKey& key : list.evicted) {
    if (key.layer != Layer::heights) continue;
    surfaces.erase(key.id);
    uploads.forget(key.id);
  }
}

const Surface* Renderer::State::surface_of(const RenderTile& tile) {
  if (!tile.heights) return nullptr;
  const auto known = surfaces.find(tile.heights_id);
  if (known != surfaces.end() && heights.find(tile.heights_id)) return &known->second;
  HeightUpload upload = uploads.take(tile.heights_id, *tile.heights, quantum_m);
  if (!heights.find(tile.heights_id)) {
    heights.add(tile.heights_id, upload);
    ++counts.uploads;
  }
  const HeightTexels& texels = upload.heights;
  Surface surface{{tile.heights_id, tile.heights, quantum_m, texels.shift == 0, std::move(upload.relief)},
                  texels.base,
                  texels.shift};
  return &surfaces.insert_or_assign(tile.heights_id, std::move(surface)).first->second;
}

int Renderer::State::imagery_array_of(const RenderTile& tile) {
  for (std::size_t i = 0; i < imagery.size(); ++i) {
    if (imagery[i].format() != tile.imagery->format) continue;
    if (imagery[i].supported()) return static_cast<int>(i);
    if (!std::exchange(refused[i], true)) {
      errors.push_back(failed("OpenGL: imagery: expected a context with BC" +
                              std::to_string(static_cast<int>(tile.imagery->format)) + ", found none"));
    }
  }
  return -1;
}

void Renderer::State::show_heights(const RenderTile& tile, const GridPatch& grid, PatchRecord& record) {
  const Surface* surface = surface_of(tile);
  if (!surface) return;
  const Window window = window_in(tile.heights_id, grid.area);
  const double cells = tile_size - 1;
  record.height_layer = static_cast<std::int32_t>(*heights.find(tile.heights_id));
  record.height_base = surface->base;
  record.height_shift = surface->shift;
  record.height_step = static_cast<float>(window.scale * cells / grid.cells());
  record.height_origin = glm::vec2(window.x * cells, window.y * cells);
}

void Renderer::State::show_imagery(const RenderTile& tile, const GridPatch& grid, PatchRecord& record) {
  if (!tile.imagery) return;
  const int index = imagery_array_of(tile);
  if (index < 0) return;
  ImageryTextures& array = imagery[static_cast<std::size_t>(index)];
  auto layer = array.find(tile.imagery_id);
  if (!layer) {
    layer = array.add(tile.imagery_id, *tile.imagery);
    ++counts.uploads;
  }
  const Window window = window_in(tile.imagery_id, grid.area);
  record.imagery_array = index + 1;
  record.imagery_layer = static_cast<std::int32_t>(*layer);
  record.imagery_origin = glm::vec2(window.x, window.y);
  record.imagery_scale = static_cast<float>(window.scale);
}

std::vector<PatchRecord> Renderer::State::records_of(const MeshPlan& plan,
                                                     std::span<const RenderTile* const> tiles) {
  std::vector<PatchRecord> records;
  records.reserve(plan.patches.size());
  for (const GridPatch& grid : plan.patches) {
    PatchRecord record;
    record.column_table = columns.first_entry(grid.area.level, grid.area.x);
    record.row_table = rows.first_entry(grid.area.level, grid.area.y);
    record.cells_log2 = static_cast<std::uint32_t>(grid.cells_log2);
    record.cells_east = static_cast<std::uint32_t>(grid.cells_east);
    record.cells_north = static_cast<std::uint32_t>(grid.cells_north);
    record.perimeter = static_cast<std::uint32_t>(grid.perimeter);
    record.listed_sides = grid.listed_sides;
    record.level = grid.area.level;
    show_heights(*tiles[grid.from], grid, record);
    show_imagery(*tiles[grid.from], grid, record);
    records.push_back(record);
  }
  return records;
}

MeshPlan Renderer::State::plan(std::span<const RenderTile* const> tiles, const ViewState& view,
                               const FrameLook& look, const CameraFrame& camera) {
  std::vector<MeshArea> areas;
  for (const RenderTile* tile : tiles) {
    const Surface* surface = surface_of(*tile);
    areas.push_back({tile->area, surface ? &surface->tile : nullptr, tile->distance_m});
  }
  MeshRules rules;
  rules.tile_size = tile_size;
  rules.pixels_per_radian = 1 / pixel_footprint_m(view, 1);
  rules.tolerance_px = look.tolerance_px;
  rules.eye = camera.position;
  rules.inward = inward_normals(camera, view);
  return plan_mesh(areas, rules);
}

void Renderer::State::set_uniforms(const CameraFrame& camera, const ViewState& view, const FrameLook& look) {
  const GLuint program = terrain.name();
  const glm::mat4 clip(clip_from_eye(camera, view));
  glProgramUniform3d(program, kEye, camera.position.x, camera.position.y, camera.position.z);
  glProgramUniformMatrix4fv(program, kClip, 1, GL_FALSE, glm::value_ptr(clip));
  glProgramUniform1ui(program, kCells, static_cast<GLuint>(cells_log2_of(tile_size)));
  glProgramUniform1f(program, kQuantum, static_cast<float>(quantum_m));
  const glm::vec4 horizon(horizon_plane(camera.position));
  glProgramUniform4f(program, kHorizon, horizon.x, horizon.y, horizon.z, horizon.w);
  for (const GLuint each : {program, sky.name()}) {
    const glm::vec3 eye(camera.position), sun(look.to_sun);
    glProgramUniform1f(each, kEyeHeight, static_cast<float>(view.height_m));
    glProgramUniform1ui(each, kLook, (look.level_colours ? kLevelColours : 0u) | (look.fog ? kFog : 0u));
    glProgramUniform3f(each, kEyeFloat, eye.x, eye.y, eye.z);
    glProgramUniform3f(each, kSun, sun.x, sun.y, sun.z);
  }
}

void Renderer::State::draw_patches(const MeshPlan& plan, const std::vector<PatchRecord>& records) {
  // Sorted by grid, so that each size of grid is one instanced call.
  std::array<std::vector<std::uint32_t>, kMaxCellsLog2 + 1> by_grid;
  for (std::uint32_t i = 0; i < records.size(); ++i) by_grid[records[i].cells_log2].push_back(i);
  std::vector<std::uint32_t> order;
  for (const auto& group : by_grid) order.insert(order.end(), group.begin(), group.end());

  const auto fill = [](const Buffer& buffer, const auto& values) {
    const std::size_t bytes =
        std::max<std::size_t>(values.size(), 1) * sizeof values[0];  // none cannot be bound
    glNamedBufferData(buffer.name(), static_cast<GLsizeiptr>(bytes), values.empty() ? nullptr : values.data(),
                      GL_STREAM_DRAW);
  };
  fill(patch_buffer, records);
  fill(perimeter_buffer, plan.perimeter);
  fill(instance_buffer, order);

  glUseProgram(terrain.name());
  glBindVertexArray(vertex_array.name());
  const std::array<GLuint, 4> buffers = {patch_buffer.name(), perimeter_buffer.name(), columns.name(),
                                         rows.name()};
  glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizei>(buffers.size()), buffers.data());
  heights.bind(0, 1);
  for (std::size_t i = 0; i < imagery.size(); ++i) imagery[i].bind(static_cast<GLuint>(2 + i));
  std::uint32_t first = 0;
  for (int k = 0; k <= kMaxCellsLog2; ++k) {
    const auto instances = static_cast<std::uint32_t>(by_grid[static_cast<std::size_t>(k)].size());
    if (instances == 0) continue;
    glVertexArrayElementBuffer(vertex_array.name(), indices.buffer(k));
    glDrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(GridIndices::count(k)),
                                        GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(instances), first);
    first += instances;
    counts.triangles += std::size_t{instances} * GridIndices::count(k) / 3;
  }
  counts.patches = records.size();
}

void Renderer::State::draw_sky(const CameraFrame& camera, const ViewState& view, const FrameLook& look) {
  if (look.hole_colour) return;
  const glm::mat4 rays = ray_from_clip(camera, view);
  glProgramUniformMatrix4fv(sky.name(), 0, 1, GL_FALSE, glm::value_ptr(rays));
  glUseProgram(sky.name());
  glBindVertexArray(vertex_array.name());
  glDepthFunc(GL_EQUAL);  // only where nothing was drawn
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(int tile_size, double quantum_m, HeightUploads& uploads) {
  if (epoxy_gl_version() < 45) {
    return failed("OpenGL: context: expected version 4.5, found " + std::to_string(epoxy_gl_version() / 10) +
                  "." + std::to_string(epoxy_gl_version() % 10));
  }
  auto state = std::make_unique<State>(tile_size, quantum_m, uploads);
  Result<Program> terrain = link_program("terrain");
  if (!terrain) return terrain.error();
  Result<Program> sky = link_program("sky");
  if (!sky) return sky.error();
  state->terrain = std::move(*terrain);
  state->sky = std::move(*sky);
  state->vertex_array = make_vertex_array();
  const GLuint vao = state->vertex_array.name();
  glVertexArrayVertexBuffer(vao, 0, state->instance_buffer.name(), 0, sizeof(std::uint32_t));
  glEnableVertexArrayAttrib(vao, 0);
  glVertexArrayAttribIFormat(vao, 0, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(vao, 0, 0);
  glVertexArrayBindingDivisor(vao, 0, 1);
  return Renderer(std::move(state));
}

FrameCounts Renderer::draw(const RenderList& list, const ViewState& view, const FrameLook& look,
                           unsigned framebuffer) {
  // 1. What is seen, uploaded where it was not.
  State& s = *state_;
  s.begin_frame(list);
  std::vector<const RenderTile*> tiles;
  for (const RenderTile& tile : list.tiles) {
    if (tile.visible) tiles.push_back(&tile);
  }
  // 2. The grids, and what they show.
  const CameraFrame camera = camera_frame(view);
  const MeshPlan plan = s.plan(tiles, view, look, camera);
  const std::vector<PatchRecord> records = s.records_of(plan, tiles);
  // 3. Draw: terrain, then the sky where nothing is.
  s.set_uniforms(camera, view, look);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, view.viewport_width_px, view.viewport_height_px);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);  // rounding may turn a sliver over; it must be drawn all the same
  glEnable(GL_CLIP_DISTANCE0);
  glEnable(GL_CLIP_DISTANCE1);
  glDepthFunc(GL_GREATER);
  const glm::vec3 background = look.hole_colour.value_or(glm::vec3(0));
  glClearColor(background.r, background.g, background.b, 1);
  glClearDepth(0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glPolygonMode(GL_FRONT_AND_BACK, look.wireframe ? GL_LINE : GL_FILL);
  if (!records.empty()) s.draw_patches(plan, records);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_CLIP_DISTANCE0);
  glDisable(GL_CLIP_DISTANCE1);
  s.draw_sky(camera, view, look);
  s.counts.gpu_bytes = s.heights.bytes() + s.columns.bytes() + s.rows.bytes();
  for (const ImageryTextures& array : s.imagery) s.counts.gpu_bytes += array.bytes();
  return s.counts;
}

std::vector<Error> Renderer::take_errors() {
  return std::exchange(state_->errors, {});
}

}  // namespace cairn::gl
