#include "runtime/viewer/scene.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <string>
#include <thread>
#include <utility>

#include "cairn/remote_pack.h"
#include "runtime/flight/camera_text.h"
#include "runtime/gl/view_transform.h"
#include "runtime/light/sun_shadows.h"
#include "runtime/surface/drawn_ground.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/viewer/drape_file.h"
#include "runtime/viewer/method_mesh.h"
#include "runtime/viewer/method_scene.h"

namespace cairn::viewer {
namespace {

constexpr std::uint64_t kMostIndexBytesAhead = std::uint64_t{16} << 20;  // a million tiles

std::vector<Error> missing_layers(const std::string& name, const PackReader& pack) {
  std::vector<Error> missing;
  if (!pack.levels(Layer::heights)) {
    missing.push_back(
        bad_data(name + ": heights: expected a layer of them, found none; all is drawn at height 0"));
  }
  if (!pack.levels(Layer::imagery)) {
    missing.push_back(
        bad_data(name + ": imagery: expected a layer of it, found none; colours are by height"));
  }
  return missing;
}

Error unknown_method(const std::string& name) {
  std::string names;
  for (const LodMethodInfo* method : lod_methods()) {
    names += (names.empty() ? "" : ", ") + std::string(method->name);
  }
  return usage_error("--method: expected one of " + names + ", found " + name);
}

Error unknown_tint(const std::string& name) {
  std::string names;
  for (const NamedTint& tint : tints()) names += (names.empty() ? "" : ", ") + std::string(tint.name);
  return usage_error("--tint: expected one of " + names + ", found " + name);
}

}  // namespace

Scene::Scene(std::shared_ptr<const PackReader> pack, Surface surface, Terrain terrain, gl::Renderer renderer)
    : pack_(std::move(pack)),
      surface_(std::move(surface)),
      terrain_(std::move(terrain)),
      renderer_(std::move(renderer)) {}

Result<Scene> Scene::open(const Options& options) {
  Result<PackReader> reader = open_pack(options.pack.string());
  if (!reader) return reader.error();
  auto pack = std::make_shared<const PackReader>(std::move(*reader));
  const PackHeader& header = pack->header();
  // A frame that asks for a page of the index would wait for the server.
  const bool is_index_small = header.metadata_offset - header.index_offset <= kMostIndexBytesAhead;
  if (is_remote(options.pack.string()) && is_index_small) {
    if (const Status status = pack->read_index(); !status) return status.error();
  }
  Surface surface(header);
  Result<gl::Renderer> renderer =
      gl::Renderer::create(header.tile_size, header.quantum_m, pack->entry_count());
  if (!renderer) return renderer.error();
  TerrainOptions terrain_options;
  terrain_options.cache_bytes = options.cache_mib << 20;
  terrain_options.tolerance_px = options.tolerance_px;
  terrain_options.object_px =
      options.no_objects ? std::numeric_limits<double>::infinity() : options.object_px;
  Result<Terrain> terrain = Terrain::open(pack, terrain_options, surface.preparing(read_from(pack)));
  if (!terrain) return terrain.error();
  Scene scene(std::move(pack), std::move(surface), std::move(*terrain), std::move(*renderer));
  scene.errors_ = missing_layers(options.pack.string(), *scene.pack_);
  if (!is_remote(options.pack.string()) && scene.pack_->model_count() > 0 && !options.no_objects) {
    Result<ObjectEditor> editor = ObjectEditor::open(scene.pack_);
    if (editor) {
      scene.editor_ = std::move(*editor);
    } else {
      scene.errors_.push_back(editor.error());
    }
  }
  return scene;
}

void Scene::update(const ViewState& view, double dt_s) {
  list_ = &terrain_.update(view, dt_s);
  errors_.insert(errors_.end(), list_->errors.begin(), list_->errors.end());
}

SurfaceMesh Scene::method_mesh(const SurfaceFrame& frame, const ViewState& view, const FrameLook& look) {
  if (method_info_ != look.method) {
    method_info_ = look.method;
    method_ = look.method->create({});
  }
  const PackHeader& header = pack_->header();
  MethodScene scene = method_scene(frame.tiles, header);
  method_->prepare(scene.scene);
  SurfaceMesh mesh;
  mesh.walls = vertices_of(method_->build(scene.scene, {view, look.tolerance_px, true}), scene.scene);
  mesh.draws = std::move(scene.windows);
  mesh.triangles = mesh.walls.indices.size() / 3;
  return mesh;
}

FrameCounts Scene::draw_list(const ViewState& view, const FrameLook& look, unsigned framebuffer) {
  if (look.method) surface_.cut();
  SurfaceView shown_by{view, look.tolerance_px, look.frame_s, look.object_px};
  if (editor_) shown_by.added = editor_->placed().tiles;
  const SurfaceFrame& frame = surface_.frame(*list_, shown_by);
  frame_ = &frame;
  FrameCounts counts;
  const double begin_s = thread_cpu_s();
  counts.uploads = renderer_.take(frame);
  counts.upload_ms = 1e3 * (thread_cpu_s() - begin_s);
  ViewState eye = view;
  eye.ellipsoid = pack_->header().body.shape;
  const gl::Renderer::Camera camera{eye, clip_from_eye(eye), list_->lowest_m};
  const GlTarget target{framebuffer, 0, 0, view.viewport_width_px, view.viewport_height_px};
  gl::clear(target, look.hole_colour.value_or(glm::vec3(0)));
  GlLook shown = look;
  shown.sky = !look.hole_colour;
  shown.is_earth = pack_->header().body.is_earth();
  shown.objects = look.objects && !look.method;  // they stand on the surface's own mesh
  if (!look.method) {
    method_info_ = nullptr;
    method_.reset();
  }
  const SurfaceMesh own = look.method ? method_mesh(frame, view, look) : SurfaceMesh{};
  const SurfaceMesh& mesh = look.method ? own : frame.mesh;
  std::size_t due = 0;
  if (look.shadows) {
    if (!shadows_) shadows_ = std::make_unique<SunShadows>(pack_, kShadowThreads);
    due = renderer_.update_shadows(*shadows_, frame, mesh, look.to_sun);
    while (due > 0 && look.waits_for_shadows) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      due = renderer_.update_shadows(*shadows_, frame, mesh, look.to_sun);
    }
  }
  static_cast<GlCounts&>(counts) = renderer_.draw(frame, mesh, camera, shown, target, look.draws);
  counts.shadows_due = due;
  return counts;
}

FrameCounts Scene::draw(const ViewState& view, double dt_s, const FrameLook& look, unsigned framebuffer) {
  terrain_.set_tolerance_px(look.tolerance_px);
  update(view, dt_s);
  return draw_list(view, look, framebuffer);
}

void Scene::load_all(const ViewState& view) {
  for (update(view, 0); !list_->is_settled; update(view, 0)) {
    surface_.skip(*list_);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

double Scene::ground_m(LonLat place) const {
  const std::optional<double> listed = drawn_ground_m(*list_, pack_->header().quantum_m, place);
  const std::optional<double> drawn = surface_.ground_m(place);
  return std::max(listed.value_or(drawn.value_or(0)), drawn.value_or(listed.value_or(0)));
}

std::vector<Error> Scene::take_errors() {
  std::vector<Error> errors = renderer_.take_errors();
  errors.insert(errors.end(), std::make_move_iterator(errors_.begin()),
                std::make_move_iterator(errors_.end()));
  errors_.clear();
  return errors;
}

Result<FrameLook> look_of(const Options& options, const PackReader& pack) {
  FrameLook look;
  look.fog = !options.no_fog;
  look.sea_m = options.sea_m;
  look.contours_m = options.contours_m;
  look.slope_colours = options.slopes;
  look.imagery = options.imagery;
  look.exposure_ev = options.exposure_ev;
  if (!options.tint.empty()) {
    const NamedTint* tint = tint_named(options.tint);
    if (!tint) return unknown_tint(options.tint);
    const HeightRange range = height_range(pack);
    look.tint = stops_of(*tint, range.lowest_m, range.highest_m);
  }
  if (!options.drapes.empty()) {
    Result<Drape> drape = read_drapes(options.drapes);
    if (!drape) return drape.error();
    look.drape = std::make_shared<const Drape>(std::move(*drape));
  }
  look.shadows = !options.no_shadows;
  look.dithers = !options.no_dither;
  look.wireframe = options.wireframe;
  look.level_colours = options.levels;
  look.draws = !options.no_draw;
  look.tolerance_px = options.tolerance_px;
  look.object_px = options.object_px;
  look.objects = !options.no_objects;
  if (!options.method.empty()) {
    look.method = lod_method(options.method);
    if (!look.method) return unknown_method(options.method);
  }
  if (!options.hole_colour.empty()) {
    const Result<glm::vec3> colour = parse_colour(options.hole_colour);
    if (!colour) return colour.error();
    look.hole_colour = *colour;
  }
  return look;
}

}  // namespace cairn::viewer
