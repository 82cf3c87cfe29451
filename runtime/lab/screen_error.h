#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/status.h"
#include "runtime/lab/lab_terrain.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/screen.h"

namespace cairn {

/// A mesh with its vertices' positions, to be projected again from the next frame's camera.
struct PlacedMesh {
  std::vector<TileId> areas;                       ///< of each tile's mesh
  std::vector<std::vector<glm::dvec3>> positions;  ///< geocentric metres
  LodMesh mesh;
};
PlacedMesh place(const LodScene& scene, LodMesh mesh, int threads);

/// The measure's result for one view, in pixels.
struct ScreenError {
  double max_px = 0;
  double rms_px = 0;
  std::uint64_t samples = 0;  ///< finest samples in the viewport
  std::uint64_t holes = 0;    ///< of these, where the mesh has nothing in front of the camera
  double max_pop_px = 0;  ///< largest distance of the mesh's point at a sample from where the mesh before had
                          ///< it, both projected now, over samples that were in both viewports
  LatticePoint worst;     ///< the sample of max_px
  std::uint64_t useful_triangles = 0;  ///< that cover a quarter of a square pixel of the viewport or more
};

/// The finest surface as one camera sees it: the projections of all samples that are not void, in the
/// viewport and above the horizon. Terrain in front hides nothing.
///
/// Measures the distance in pixels between a sample and the mesh's point at its longitude and latitude, on
/// the plane of the triangle there. Projections are kept in single precision relative to the middle of the
/// viewport, which is good to 1e-4 px. Samples less than a metre in front of the camera do not count.
class FinestView {
 public:
  static Result<FinestView> of(LabTerrain& terrain, const ViewState& view, int threads);

  /// The frame before: its mesh, and the view that it was drawn for.
  struct Before {
    const PlacedMesh& mesh;
    const FinestView& finest;
  };
  /// Measures a mesh, and its popping against the frame before if there is one.
  ScreenError measure(const PlacedMesh& mesh, const Before* before) const;

  /// A mesh's vertex on a tile's grid of samples, and its place in the camera: right, up, along the view.
  struct GridVertex {
    double column = 0;
    double row = 0;
    glm::dvec3 at{};
  };

 private:
  struct Pixel {
    float u = 0;
    float v = 0;
  };
  struct Leaf {
    LatticePoint corner;
    TileId area;
    std::int64_t spacing = 0;
    int side = 0;                          ///< samples along a side
    std::vector<Pixel> samples;            ///< NaN outside the viewport
    std::vector<std::array<int, 2>> seen;  ///< of each row, the first that is and one past the last
  };
  struct Projected;
  struct Tally;

  FinestView(const ViewState& view, int threads) : view_(view), screen_(view), threads_(threads) {}
  bool fill(Leaf& leaf, const HeightTile& heights, const TileId& source, double quantum_m,
            const Occluder& occluder) const;
  Projected project(const PlacedMesh& mesh) const;
  std::uint64_t count_useful(const Projected& mesh) const;
  void draw(const Projected& mesh, const Leaf& leaf, std::vector<Pixel>& out) const;
  void draw_triangle(const GridVertex (&v)[3], const Leaf& leaf, std::vector<Pixel>& out) const;
  void compare(const Leaf& leaf, const std::vector<Pixel>& now, Tally& tally) const;
  void compare_before(const Leaf& leaf, const std::vector<Pixel>& now, const Leaf& leaf_before,
                      const std::vector<Pixel>& before, Tally& tally) const;
  static double squared_px(const Pixel& a, const Pixel& b);
  const Leaf* leaf_of(const TileId& area) const;

  ViewState view_;
  Screen screen_;
  int threads_;
  std::vector<Leaf> leaves_;
};

}  // namespace cairn
