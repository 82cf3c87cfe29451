#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cairn/tile_id.h"
#include "format/rqt_steps.h"

namespace cairn {

/// Makes the triangulations of neighbouring tiles of one level agree on the vertices of their common edges.
///
/// The result is the least set of vertices that has every tile's own and, with each vertex, those that it
/// depends on in any tile. What a vertex on one edge depends on at other edges does not depend on heights, so
/// only borders are kept: four bytes per edge sample of each tile. The result does not depend on the order of
/// add(). Tiles across the antimeridian are neighbours from level -3 on, where the grid lines up.
class RqtBorders {
 public:
  explicit RqtBorders(int tile_size);

  /// REQUIRES: all tiles are of one level.
  void add(const TileId& id, const RqtSteps& own);
  /// Finds the least set. Call it once all tiles are added.
  void settle();
  /// Adds the tile's vertices of that set to its own triangulations.
  void apply(const TileId& id, RqtSteps& own) const;

 private:
  // The vertices of the southern, eastern, northern and western edge but the corners, each from the west or
  // south.
  using Border = std::vector<std::uint8_t>;
  struct Place {
    int column;
    int row;
  };

  Place place_of(std::size_t i) const;
  std::size_t number_of(Place place) const;
  bool is_on_border(Place place) const;
  bool is_corner(Place place) const;
  std::vector<std::uint16_t> needs_on_border(std::size_t i) const;
  void raise(const TileId& id, Border& border, std::size_t i, std::uint8_t steps);
  void pass_on(const TileId& id, const Border& border, int side);

  int size_;
  std::vector<std::vector<std::uint16_t>> needs_;  // of each border vertex, those on the border
  std::unordered_map<TileId, Border> borders_;
  std::vector<TileId> changed_;
};

}  // namespace cairn
