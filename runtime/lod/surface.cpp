// Our own: what `cairn view` draws (runtime/surface).
//
// When a tile is loaded, every sample gets the number of the tile's nested restricted quadtree triangulations
// that have it (Pajarola 1998; Intel 2012, "Adaptive Triangulation"), tolerances a third root of 2 apart
// (VertexSteps). A frame splits tiles into patches of 16 to 64 cells, until one tolerance suits all of a
// patch (ScreenErrorBudget), and takes of each the coarsest triangulation within it. Patches of one level
// that touch take the vertices of both along their common side, with what these need (join_sides); between
// levels each keeps its rim, and an upright wall joins the two (append_walls). So a frame's work is one of
// patches, and triangles are made only where a patch's choice is a new one.
//
// Here every patch is built anew in each frame, which `building` counts; the viewer keeps them.
//
// Guarantee: that of the method `cairn`.

#include <memory>
#include <unordered_map>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/rim_walls.h"
#include "runtime/surface/surface_plan.h"
#include "runtime/view/cpu_clock.h"

namespace cairn {
namespace {

struct PreparedSurface {
  PreparedSurface(const LodScene& scene, const LodTile& tile, bool between_samples)
      : surface(prepare_surface_tile(tile.source, tile.heights, scene.quantum_m, between_samples,
                                     scene.ellipsoid)) {}
  std::uint64_t bytes() const { return surface.bytes(); }

  SurfaceTile surface;
};

LodVertex lod_vertex(const SurfacePatch& patch, const SurfaceVertex& vertex) {
  const LatticePoint corner = south_west_of(patch.area);
  const std::int64_t width = lattice_width(patch.area.level);
  return {{corner.x + vertex.east * width / kSurfaceSide, corner.y + vertex.north * width / kSurfaceSide},
          static_cast<double>(vertex.height_m)};
}

class Surface : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { tiles_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return tiles_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const double start = thread_cpu_s();
    std::vector<SurfaceArea> areas;
    for (const LodTile& tile : scene.tiles) {
      const SurfaceTile& surface = tiles_.of(tile).surface;
      areas.push_back({tile.area, &surface, static_cast<double>(surface.id.level), false, tile.error_m});
    }
    const SurfacePlan plan = plan_surface(areas, {view.view, view.tolerance_px, scene.lowest_m, view.cull});
    const double selected = thread_cpu_s();
    LodMesh mesh;
    append_patches(plan, mesh);
    append_walls(plan, mesh);
    mesh.count(IndexForm::list, {3 * mesh.triangle_count(), plan.partition.patches.size()});
    mesh.selection_s = selected - start;
    mesh.building_s = thread_cpu_s() - selected;
    return mesh;
  }

 private:
  static void append_patches(const SurfacePlan& plan, LodMesh& mesh) {
    for (std::size_t i = 0; i < plan.partition.patches.size(); ++i) {
      const SurfacePatch& patch = plan.partition.patches[i];
      const PatchMesh made = build_patch_mesh(patch, plan.joints.sides[i]);
      if (mesh.tiles.empty() || mesh.tiles.back().tile != patch.from)
        mesh.tiles.push_back({patch.from, {}, {}});
      LodTileMesh& out = mesh.tiles.back();
      const auto first = static_cast<std::uint32_t>(out.vertices.size());
      for (const SurfaceVertex& vertex : made.vertices) out.vertices.push_back(lod_vertex(patch, vertex));
      for (std::size_t k = 0; k < made.indices.size(); k += 3)
        out.triangles.push_back(
            {first + made.indices[k], first + made.indices[k + 1], first + made.indices[k + 2]});
    }
  }

  static void append_walls(const SurfacePlan& plan, LodMesh& mesh) {
    SurfaceWalls walls;
    cairn::append_walls(plan.partition, plan.joints, walls);
    for (const SurfaceWallVertex& each : walls.vertices)
      mesh.walls.vertices.push_back(lod_vertex(plan.partition.patches[each.shown_as], each.vertex));
    for (std::size_t k = 0; k < walls.indices.size(); k += 3)
      mesh.walls.triangles.push_back({walls.indices[k], walls.indices[k + 1], walls.indices[k + 2]});
  }

  PreparedTiles<PreparedSurface> tiles_;
};

}  // namespace

extern const LodMethodInfo surface_lod_method;
const LodMethodInfo surface_lod_method{"surface", true, [](const LodOptions&) -> std::unique_ptr<LodMethod> {
                                         return std::make_unique<Surface>();
                                       }};

}  // namespace cairn
