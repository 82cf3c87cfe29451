// The method `block` (Agrawal et al. 2006, §3): blocks of 17×17 samples with a pyramid of four levels (17, 9,
// 5 and 3 samples per side). Each block is drawn at its coarsest level whose screen error is at most τ,
// decided from a table made when the tile is loaded (de Boer 2000); frustum culling by block; long strips.
//
// The error is projected at the distance of the block's box, f·e/d, as de Boer does. He leaves the angle out,
// which is exact in the middle of the viewport and up to 1/cos² too small towards its corners. A block's
// errors include the sagitta of the Earth's curvature. The tile's own error against finer ones does not
// count, so the method does not keep a tolerance.
//
// With the option geomorph, heights change gradually to those of the next coarser level while the camera goes
// from the distance where a level becomes good enough to that where the next one does (de Boer 2000's
// trilinear geomipmapping; Melkisetoğlu 2005, §4.4). What jumps nevertheless are the triangles beside a
// coarser block, and borders of tiles of different levels, where heights are not changed. The price is an
// error of up to the coarser level's.

#include <algorithm>
#include <memory>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/patches.h"
#include "runtime/lod/mesh/screen.h"

namespace cairn {
namespace {

constexpr int kBlockCells = 16;
constexpr int kPyramidLevels = 4;
constexpr double kLeastGrowth = 1.25;  ///< of a level's error, where heights change gradually

class Block : public LodMethod {
 public:
  explicit Block(const LodOptions& options) : geomorph_(options.geomorph) {}

  void prepare(const LodScene& scene) override { blocks_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return blocks_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const Screen screen(view.view);
    return mesh_of_patches(scene, view, blocks_, [&](const LodTile&, const Patch& block) {
      const double distance_m = block.volume.distance_m(screen.camera().position);
      return detail_within(block, view.tolerance_px * distance_m / screen.pixels_per_radian());
    });
  }

 private:
  PatchDetail detail_within(const Patch& block, double allowed_m) const {
    return geomorph_ ? gradual_detail(block, allowed_m) : PatchDetail{step_within(block, allowed_m), 0};
  }

  static int step_within(const Patch& block, double allowed_m) {
    int step = static_cast<int>(block.errors_m.size()) - 1;
    while (step > 0 && static_cast<double>(block.errors_m[static_cast<std::size_t>(step)]) > allowed_m)
      --step;
    return step;
  }

  /// A coarser level counts as worse by a quarter at least, so that no level is left out on the way.
  static PatchDetail gradual_detail(const Patch& block, double allowed_m) {
    double from_m = 0;
    for (std::size_t k = 1; k < block.errors_m.size(); ++k) {
      const double to_m = std::max(static_cast<double>(block.errors_m[k]), kLeastGrowth * from_m);
      if (to_m > allowed_m) return {static_cast<int>(k) - 1, (allowed_m - from_m) / (to_m - from_m)};
      from_m = to_m;
    }
    return {static_cast<int>(block.errors_m.size()) - 1, 0};
  }

  bool geomorph_;
  Patches blocks_{kBlockCells, kPyramidLevels};
};

}  // namespace

extern const LodMethodInfo block_lod_method;
const LodMethodInfo block_lod_method{
    "block", false,
    [](const LodOptions& options) -> std::unique_ptr<LodMethod> { return std::make_unique<Block>(options); }};

}  // namespace cairn
