#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/screen_error_budget.h"
#include "runtime/lod/mesh/square_errors.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {

/// Takes vertices out of a tile's mesh that the picture does not need. A hierarchy of halved squares follows
/// a step across its grid with squares that shrink towards it on both sides, and each of these needs others.
///
/// Vertex by vertex, the last of the mesh first: the triangles around it are replaced by a fan from one of
/// their other corners, if every sample within is off the fan by no more than its place in the picture allows
/// (ScreenErrorBudget). So the mesh stays without gaps and folds, and on the area's border as it is. It is
/// the vertex decimation of Schroeder, Zarge & Lorensen 1992 ("Decimation of triangle meshes"), with every
/// sample instead of the vertices before as the measure.
class VertexDecimation {
 public:
  /// Of a tile whose samples are the finest under its area.
  struct Surface {
    const TileWindow& window;
    const SquareErrors& errors;
    double quantum_m;
  };

  explicit VertexDecimation(const ScreenErrorBudget& allowance) : allowance_(allowance) {}

  /// REQUIRES: the mesh's vertices are samples of the window, and what its triangles are off by is allowed.
  void thin(const Surface& surface, LodTileMesh& mesh);

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kMostAround = 16;

  /// In cells of the window and in quanta.
  struct Place {
    int column;
    int row;
    int height;
  };
  struct Box {
    int west, south, east, north;
    int cells() const { return std::max(east - west, north - south); }
  };
  /// The triangles around a vertex, whose other corners go around it anticlockwise.
  struct Star {
    Place middle;
    std::size_t count;
    std::array<std::uint32_t, kMostAround> triangles;
    std::array<std::uint32_t, kMostAround> around;
    std::array<Place, kMostAround> places;  ///< of those around
    Box box;
    double limit;  ///< what heights within may be off by, in quanta; negative: nothing may be
  };
  /// A triangle of the fan that would take the star's place.
  struct Blade {
    const Place& a;
    const Place& b;
    const Place& c;
  };

  void find_places(const LodTileMesh& mesh);
  void link(const LodTileMesh& mesh, std::size_t triangle);
  bool is_inside(const Place& place) const;
  bool find_star(const LodTileMesh& mesh, std::uint32_t vertex, Star& star) const;
  static Box box_of(const Star& star);
  double limit_of(const Star& star) const;
  std::optional<std::size_t> apex_for(const Star& star) const;
  bool any_is_off(const Star& star, std::size_t apex) const;
  bool is_off(const Star& star, const Blade& blade) const;
  void replace(const Star& star, std::size_t apex, LodTileMesh& mesh);
  static void drop_unused(LodTileMesh& mesh);

  static Blade blade(const Star& star, std::size_t apex, std::size_t i) {
    const auto [b, c] = edge_of(star, apex, i);
    return {star.places[apex], star.places[b], star.places[c]};
  }
  /// The i-th edge around the star after its corner `apex`.
  static std::array<std::size_t, 2> edge_of(const Star& star, std::size_t apex, std::size_t i) {
    const std::size_t from = apex + i < star.count ? apex + i : apex + i - star.count;
    return {from, from + 1 < star.count ? from + 1 : 0};
  }
  static double off_at_middle(const Star& star, std::size_t apex);

  const ScreenErrorBudget& allowance_;
  const Surface* surface_ = nullptr;  ///< during thin()
  std::vector<Place> places_;         ///< of the vertices
  /// Of each vertex's corners in triangles, the last; of each corner, the one before it: 3·triangle + 0,
  /// 1, 2.
  std::vector<std::uint32_t> last_corner_;
  std::vector<std::uint32_t> corner_before_;
};

}  // namespace cairn
