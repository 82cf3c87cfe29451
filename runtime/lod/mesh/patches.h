#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/lod/mesh/build_mesh.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/view/view_frustum.h"

namespace cairn {

/// A square part of a tile's window that is drawn as one grid, and what was worked out at loading.
struct Patch {
  int column = 0;  ///< its south-west sample, in the tile's window
  int row = 0;
  int cells = 0;                ///< sample intervals along a side: a power of two
  BoundingVolume volume;        ///< without a horizon point where the patch is a part of a tile
  std::vector<float> errors_m;  ///< by k, of the grid of every 2^k-th sample: patch_errors_m()
};

/// The patches of each tile of a scene, kept while the scene has the tile.
class Patches {
 public:
  /// Makes patches of `cells` intervals, or as large as the window where that is smaller, with `error_steps`
  /// entries of errors_m each.
  Patches(int cells, int error_steps) : cells_(cells), error_steps_(error_steps) {}

  void prepare(const LodScene& scene);
  const std::vector<Patch>& of(const LodTile& tile) const { return kept_.at(tile.area).patches; }
  std::uint64_t bytes() const;

 private:
  struct Kept {
    TileId source;
    std::vector<Patch> patches;
  };
  std::vector<Patch> make(const LodScene& scene, const LodTile& tile) const;

  int cells_;
  int error_steps_;
  std::unordered_map<TileId, Kept> kept_;
};

/// Returns for each k < steps the largest distance, in metres, of a patch's samples from a decimated grid.
/// The grid has every 2^k-th sample and diagonals from south-west to north-east. The distance is the vertical
/// one plus the sagitta of the Earth's curvature over a cell, R(δφ²+δλ²cos²φ)/8.
std::vector<float> patch_errors_m(const LodScene& scene, const LodTile& tile, const Patch& patch, int steps);

/// How a patch is drawn: with every 2^step-th sample. `morph` is the share, 0 to 1, that the surface of every
/// 2^(step+1)-th one has in its heights.
struct PatchDetail {
  int step = 0;
  double morph = 0;
};

struct ChosenPatch {
  std::size_t tile = 0;  ///< in the scene
  const Patch* patch = nullptr;
  PatchDetail detail;
};

/// Appends the patches' grids, grouped by tile. REQUIRES: `chosen` is in ascending order of tiles.
///
/// Where two patches of one size and spacing meet, within a tile or across tiles, the finer one's vertices
/// that the coarser one lacks are moved onto the nearest that it has, so that edge triangles collapse (Vaněk
/// & Ježek 2004, fig. 4). To leave these vertices out gives equal triangles (Agrawal et al. 2006, fig. 3).
/// Patches of different sizes are left to remove_t_junctions(). On a common side of patches of one step the
/// larger morph counts, of different steps that of the coarser patch, and beside a patch of another size
/// none.
void append_patches(const LodScene& scene, std::span<const ChosenPatch> chosen, LodMesh& mesh);

/// Returns the mesh of all patches that may be visible, each with the PatchDetail that detail_of(tile, patch)
/// returns.
template <class DetailOf>
LodMesh mesh_of_patches(const LodScene& scene, const LodView& view, const Patches& patches,
                        const DetailOf& detail_of) {
  const auto choose = [&] {
    const ViewFrustum frustum(view.view, Occluder(scene.lowest_m, scene.ellipsoid));
    std::vector<ChosenPatch> chosen;
    for (const std::size_t index : tiles_in_view(scene, view)) {
      const LodTile& tile = scene.tiles[index];
      for (const Patch& patch : patches.of(tile)) {
        if (!view.cull || frustum.sees(patch.volume))
          chosen.push_back({index, &patch, detail_of(tile, patch)});
      }
    }
    return chosen;
  };
  return build_mesh(scene, choose, [&](const std::vector<ChosenPatch>& chosen, LodMesh& mesh) {
    append_patches(scene, chosen, mesh);
  });
}

}  // namespace cairn
