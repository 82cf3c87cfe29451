#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {

/// Removes vertices from a tile's mesh that the tolerance does not need (Schroeder et al. 1992).
///
/// A hierarchy of halved squares follows a step across its grid with squares that shrink towards it on both
/// sides, and each of these depends on others; that is what is removed here. Vertex by vertex, the last one
/// of the mesh first, the triangles around it are replaced by a fan from one of their other corners, if every
/// sample under the fan is within the vertical error that ScreenErrorBudget allows there. So the mesh has no
/// gaps and no folds, and keeps its vertices on the area's border. Departure from the paper: the measure is
/// the distance of every sample, not of the removed vertices.
class VertexDecimation {
 public:
  /// A tile whose samples are the finest under its area.
  struct Surface {
    const TileWindow& window;
    const SquareErrors& errors;
    double quantum_m;
  };

  explicit VertexDecimation(const ScreenErrorBudget& budget) : budget_(budget) {}

  /// Decimates the mesh. REQUIRES: its vertices are samples of the window; its triangles are within the
  /// budget.
  void decimate(const Surface& surface, LodTileMesh& mesh);

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kMaxNeighbours = 16;

  /// A sample: its address in the window, its height in quanta.
  struct Place {
    int column;
    int row;
    int height;
  };
  struct Box {
    int west, south, east, north;
    int cells() const { return std::max(east - west, north - south); }
  };
  /// A vertex with the triangles around it and, anticlockwise, their other corners.
  struct OneRing {
    Place centre;
    std::size_t count;
    std::array<std::uint32_t, kMaxNeighbours> triangles;
    std::array<std::uint32_t, kMaxNeighbours> neighbours;
    std::array<Place, kMaxNeighbours> places;  ///< of the neighbours
    Box box;
    double limit;  ///< the allowed vertical error of samples under it, in quanta; none if negative
  };
  /// A triangle of the fan that would replace the ring's triangles.
  struct FanTriangle {
    const Place& a;
    const Place& b;
    const Place& c;
  };

  void find_places(const LodTileMesh& mesh);
  void link(const LodTileMesh& mesh, std::size_t triangle);
  bool is_inside(const Place& place) const;
  bool find_one_ring(const LodTileMesh& mesh, std::uint32_t vertex, OneRing& ring) const;
  static Box box_of(const OneRing& ring);
  double limit_of(const OneRing& ring) const;
  std::optional<std::size_t> apex_for(const OneRing& ring) const;
  bool any_exceeds(const OneRing& ring, std::size_t apex) const;
  bool exceeds(const OneRing& ring, const FanTriangle& triangle) const;
  void replace(const OneRing& ring, std::size_t apex, LodTileMesh& mesh);
  static void drop_unused(LodTileMesh& mesh);

  static FanTriangle fan_triangle(const OneRing& ring, std::size_t apex, std::size_t i) {
    const auto [b, c] = edge_of(ring, apex, i);
    return {ring.places[apex], ring.places[b], ring.places[c]};
  }
  /// Returns the ring's i-th edge after its corner `apex`.
  static std::array<std::size_t, 2> edge_of(const OneRing& ring, std::size_t apex, std::size_t i) {
    const std::size_t from = apex + i < ring.count ? apex + i : apex + i - ring.count;
    return {from, from + 1 < ring.count ? from + 1 : 0};
  }
  static double distance_from_centre(const OneRing& ring, std::size_t apex);

  const ScreenErrorBudget& budget_;
  const Surface* surface_ = nullptr;  ///< during decimate()
  std::vector<Place> places_;         ///< of the mesh's vertices
  /// Lists of each vertex's corners; a corner is numbered 3·triangle + 0, 1, 2. last_corner_ has each
  /// vertex's last corner, corner_before_ each corner's predecessor.
  std::vector<std::uint32_t> last_corner_;
  std::vector<std::uint32_t> corner_before_;
};

}  // namespace cairn
