#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Upright ribbons of triangles between the rims of squares that were meshed each by itself (Ulrich 2002).
///
/// Where the rims on the two sides of a line have different vertices, a ribbon fills what lies between them,
/// from each vertex that both have to the next. So the mesh is closed, and no vertex of a square is moved or
/// added.
class RimRibbons {
 public:
  /// On which side of its rim a square lies.
  enum Side : std::uint8_t { below, above };  ///< to the west or south of the rim; to the east or north

  /// Adds a rim on a line of constant longitude (`upright`) or latitude. `vertices` run along the line, the
  /// least x or y first, and are at least two. REQUIRES: no other rim of this side covers a part of it.
  void add(bool upright, Side side, std::span<const LodVertex> vertices);

  /// Appends the ribbons to the walls. REQUIRES: vertices at one place have one height.
  void append_to(LodTileMesh& walls);

 private:
  struct Piece {
    std::int64_t from = 0;  ///< along the line
    std::vector<LodVertex> vertices;
  };
  using Sides = std::array<std::vector<Piece>, 2>;

  std::map<std::pair<bool, std::int64_t>, Sides> lines_;
};

}  // namespace cairn
