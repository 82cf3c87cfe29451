#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/scene/scene_map.h"
#include "runtime/stats/walk.h"

namespace cairn {

/// Which maps are counted: the K levels of one pattern.
struct CountSpec {
  TileId start;    ///< the camera's tile before the first move
  int levels = 4;  ///< K; start.level - K + 1 >= kMinLevel
  RefinementPattern pattern = RefinementPattern::restricted;
  int window_tiles = 8;
  HasTile has;  ///< null for the endless world, where every tile exists
};

/// The counts of one move.
struct MoveCount {
  std::size_t total = 0;       ///< tiles of the map after the move
  std::size_t difference = 0;  ///< those of them that the map before the move did not have
};

/// Returns a tile from which neither 2^17 moves nor the tiles of K <= 9 levels reach a border of the world.
/// It lies at a corner of the tiles of all those levels.
TileId endless_world();

/// Returns the tiles of the spec's K levels that a map has with the camera in tile `eye`.
std::vector<TileId> counted_tiles(const CountSpec& spec, const TileId& eye);

/// Returns the tiles that are shown along a walk: at the start and after each move.
std::vector<std::vector<TileId>> shown_along(const CountSpec& spec, std::span<const Move> walk);

/// Returns the counts of each move, given the tiles that are shown before the first and after each.
std::vector<MoveCount> count_moves(std::span<const std::vector<TileId>> shown);

/// Returns the counts of every one of `moves` from every camera tile of a square of 2^(K+2) tiles north-east
/// of the start.
std::vector<MoveCount> count_exhaustively(const CountSpec& spec, std::span<const Move> moves);

}  // namespace cairn
