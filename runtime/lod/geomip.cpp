// The method `geomip` (Vaněk & Ježek 2004, §3): patches of 2^n+1 samples, drawn with 2^k+1,
//
//   k = n (1 - ((dist - mindist) / (maxdist - mindist))^exp),  n up to mindist, 0 from maxdist,
//
// with moved edge vertices, frustum culling by box, and one strip with degenerate triangles per patch. The
// paper leaves n, mindist, maxdist and exp to the user. Here n = 6, k is rounded up, and dist is to the
// patch's middle. Samples are kPixels · tolerance apart on the screen at mindist; at maxdist = 2^n mindist
// the patch's corners are. exp = 0.3 comes closest to spacings that grow with distance between the two. The
// rule knows no heights, so the method has no tolerance to keep.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/patches.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {
namespace {

constexpr int kPatchCells = 64;
constexpr double kPixels = 4;
constexpr double kExponent = 0.3;

class GeoMip : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { patches_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return patches_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const Screen screen(view.view);
    return mesh_of_patches(scene, view, patches_, [&](const LodTile& tile, const Patch& patch) {
      const double spacing_m =
          tile_width_degrees(tile.source.level) / (scene.tile_size - 1) * scene.ellipsoid.equator_degree_m();
      const double min_m = spacing_m * screen.pixels_per_radian() / (kPixels * view.tolerance_px);
      const double distance_m = glm::distance(screen.camera().position, patch.volume.centre);
      return PatchDetail{step_at(distance_m, min_m, patch.cells)};
    });
  }

 private:
  /// Returns n - k.
  static int step_at(double distance_m, double min_m, int cells) {
    const int n = std::ilogb(cells);
    const double part = std::clamp((distance_m - min_m) / ((cells - 1) * min_m + 1e-9), 0.0, 1.0);
    return n - static_cast<int>(std::ceil(n * (1 - std::pow(part, kExponent))));
  }

  Patches patches_{kPatchCells, 0};
};

}  // namespace

extern const LodMethodInfo geomip_lod_method;
const LodMethodInfo geomip_lod_method{"geomip", false, create_without_options<GeoMip>};

}  // namespace cairn
