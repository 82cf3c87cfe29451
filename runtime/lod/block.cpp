// The method `block` (Agrawal et al. 2006, §3): blocks of 17×17 samples with a pyramid of four levels (17, 9,
// 5 and 3 samples per side). Each block is drawn at its coarsest level whose screen error is at most τ,
// decided from a table made when the tile is loaded (de Boer 2000); frustum culling by block; long strips.
//
// The error is projected at the distance of the block's box, f·e/d, as de Boer does. He leaves the angle out,
// which is exact in the middle of the viewport and up to 1/cos² too small towards its corners. A block's
// errors include the sagitta of the Earth's curvature. The tile's own error against finer ones does not
// count, so the method does not keep a tolerance.

#include <algorithm>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/patches.h"
#include "runtime/lod/mesh/screen.h"

namespace cairn {
namespace {

constexpr int kBlockCells = 16;
constexpr int kPyramidLevels = 4;

class Block : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { blocks_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return blocks_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const Screen screen(view.view);
    return mesh_of_patches(scene, view, blocks_, [&](const LodTile&, const Patch& block) {
      const double distance_m = block.volume.distance_m(screen.camera().position);
      return step_within(block, view.tolerance_px * distance_m / screen.pixels_per_radian());
    });
  }

 private:
  static int step_within(const Patch& block, double allowed_m) {
    int step = static_cast<int>(block.errors_m.size()) - 1;
    while (step > 0 && static_cast<double>(block.errors_m[static_cast<std::size_t>(step)]) > allowed_m)
      --step;
    return step;
  }

  Patches blocks_{kBlockCells, kPyramidLevels};
};

}  // namespace

extern const LodMethodInfo block_lod_method;
const LodMethodInfo block_lod_method{"block", false, create_without_options<Block>};

}  // namespace cairn
