#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/lod/mesh/cpu_clock.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/remove_t_junctions.h"

namespace cairn {

/// A square part of a tile's window that is drawn as one grid, with what is known of it from loading.
struct Patch {
  int column = 0;  ///< its south-west sample, in the tile's window
  int row = 0;
  int cells = 0;                ///< sample intervals along a side: a power of two
  BoundingVolume volume;        ///< without its horizon point where the patch is a part of a tile
  std::vector<float> errors_m;  ///< of every 2^k-th sample; see patch_errors
};

/// The patches of each tile of a scene, kept while the scene has the tile.
class Patches {
 public:
  /// Patches of `cells` intervals, or as large as the window where that is smaller. `error_steps` entries of
  /// errors_m are worked out; 0 for none.
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

/// Entry k: the largest vertical distance of a patch's samples from the grid of its every 2^k-th sample, with
/// diagonals from south-west to north-east, plus what the grid's chords lose on the Earth's curvature,
/// R(δφ²+δλ²cos²φ)/8, the error of linear interpolation.
std::vector<float> patch_errors(const LodScene& scene, const LodTile& tile, const Patch& patch, int steps);

/// A patch to draw with every 2^step-th sample.
struct ChosenPatch {
  std::size_t tile = 0;  ///< in the scene
  const Patch* patch = nullptr;
  int step = 0;
};

/// Appends the patches' grids, grouped by tile. Where two of one size and spacing meet, within a tile or
/// across tiles, the vertices of the finer that the coarser has not are moved onto the next that it has, so
/// that its edge triangles collapse: [0, Fig. 4]; leaving those vertices out, as [1, Fig. 3] does, gives the
/// same triangles. Patches of other sizes are left to remove_t_junctions(). REQUIRES: ascending tiles.
void append_patches(const LodScene& scene, std::span<const ChosenPatch> chosen, LodMesh& mesh);

/// The mesh of what choose() returns, a vector of ChosenPatch: appended, joined and timed.
template <class Choose>
LodMesh mesh_of_patches(const LodScene& scene, const Choose& choose) {
  const double start = thread_cpu_s();
  const std::vector<ChosenPatch> chosen = choose();
  const double selected = thread_cpu_s();
  LodMesh mesh;
  append_patches(scene, chosen, mesh);
  remove_t_junctions(scene, mesh);
  mesh.selection_s = selected - start;
  mesh.building_s = thread_cpu_s() - selected;
  return mesh;
}

}  // namespace cairn
