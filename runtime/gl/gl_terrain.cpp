#include "cairn/gl_terrain.h"

#include <utility>

#include "cairn/surface.h"
#include "runtime/gl/renderer.h"
#include "runtime/gl/view_transform.h"
#include "runtime/light/sun_shadows.h"

namespace cairn {

glm::dmat4 clip_from_eye(const ViewState& view) {
  return gl::clip_from_eye(camera_frame(view), view);
}

struct GlTerrain::State {
  Surface surface;
  Terrain terrain;
  gl::Renderer renderer;
  std::shared_ptr<const PackReader> pack;
  double object_px = 2;
  std::unique_ptr<SunShadows> shadows;  ///< from the first picture that has any
  const SurfaceFrame* frame = nullptr;
  const RenderList* list = nullptr;
  ViewState view;
};

GlTerrain::GlTerrain(std::unique_ptr<State> state) : state_(std::move(state)) {}
GlTerrain::GlTerrain(GlTerrain&&) noexcept = default;
GlTerrain& GlTerrain::operator=(GlTerrain&&) noexcept = default;
GlTerrain::~GlTerrain() = default;

Result<GlTerrain> GlTerrain::create(std::shared_ptr<const PackReader> pack, const TerrainOptions& options) {
  const PackHeader& header = pack->header();
  Result<gl::Renderer> renderer =
      gl::Renderer::create(header.tile_size, header.quantum_m, pack->entry_count());
  if (!renderer) return renderer.error();
  Surface surface(header);
  Result<Terrain> terrain = Terrain::open(pack, options, surface.preparing(read_from(pack)));
  if (!terrain) return terrain.error();
  return GlTerrain(std::make_unique<State>(State{std::move(surface),
                                                 std::move(*terrain),
                                                 std::move(*renderer),
                                                 pack,
                                                 options.object_px,
                                                 nullptr,
                                                 nullptr,
                                                 nullptr,
                                                 {}}));
}

const RenderList& GlTerrain::update(const ViewState& view, double dt_s, double tolerance_px) {
  State& s = *state_;
  s.view = view;
  s.view.ellipsoid = s.pack->header().body.shape;
  s.terrain.set_tolerance_px(tolerance_px);
  s.list = &s.terrain.update(view, dt_s);
  s.frame = &s.surface.frame(*s.list, {view, tolerance_px, dt_s, s.object_px});
  s.renderer.take(*s.frame);
  return *s.list;
}

void GlTerrain::cut() {
  state_->surface.cut();
}

GlCounts GlTerrain::draw(const GlLook& look, const GlTarget& target) {
  return draw(look, target, clip_from_eye(state_->view));
}

GlCounts GlTerrain::draw(const GlLook& look, const GlTarget& target, const glm::dmat4& projection) {
  State& s = *state_;
  if (!s.frame) return {};
  GlLook own = look;
  own.is_earth = look.is_earth && s.pack->header().body.is_earth();
  std::size_t due = 0;
  if (look.shadows && !look.depth_only) {
    if (!s.shadows) s.shadows = std::make_unique<SunShadows>(s.pack, kShadowThreads);
    due = s.renderer.update_shadows(*s.shadows, *s.frame, s.frame->mesh, look.to_sun);
  }
  GlCounts counts =
      s.renderer.draw(*s.frame, s.frame->mesh, {s.view, projection, s.list->lowest_m}, own, target);
  counts.shadows_due = due;
  return counts;
}

const Terrain& GlTerrain::terrain() const {
  return state_->terrain;
}

std::vector<Error> GlTerrain::take_errors() {
  return state_->renderer.take_errors();
}

}  // namespace cairn
