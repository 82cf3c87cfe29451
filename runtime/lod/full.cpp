// The method `full`: every sample of every tile (Melkisetoğlu 2005, §3.1), as one strip with degenerate
// triangles per tile (Vaněk & Ježek 2004, §2, table 1).

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/build_mesh.h"
#include "runtime/lod/mesh/index_forms.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {
namespace {

LodTileMesh every_sample(const LodScene& scene, std::size_t index) {
  const TileWindow window(scene, scene.tiles[index]);
  const int side = window.cells() + 1;
  LodTileMesh mesh{index, {}, triangles_of_strip(grid_indices(IndexForm::degenerate_strip, side, side))};
  mesh.vertices.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) mesh.vertices.push_back(window.vertex(c, r));
  }
  return mesh;
}

class Full : public LodMethod {
 public:
  void prepare(const LodScene&) override {}
  std::uint64_t prepared_bytes() const override { return 0; }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const auto append = [&](const std::vector<std::size_t>& drawn, LodMesh& mesh) {
      for (const std::size_t index : drawn) {
        mesh.tiles.push_back(every_sample(scene, index));
        const int side = TileWindow(scene, scene.tiles[index]).cells() + 1;
        for (const IndexForm form : kIndexForms) mesh.count(form, grid_index_count(form, side, side));
      }
    };
    return build_mesh(
        scene, [&] { return tiles_in_view(scene, view); }, append);
  }
};

}  // namespace

extern const LodMethodInfo full_lod_method;
const LodMethodInfo full_lod_method{"full", true, create_without_options<Full>};

}  // namespace cairn
