#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/scene/scene_map.h"
#include "runtime/stats/walk.h"

namespace cairn {

/// What is counted: the K levels of the maps of one pattern.
struct CountSpec {
  TileId start;    ///< the eye's tile before the first move
  int levels = 4;  ///< K; start.level - K + 1 >= kMinLevel
  RefinementPattern pattern = RefinementPattern::restricted;
  int window_tiles = 8;
  HasTile has;  ///< null: the endless world, where every tile exists
};

/// One move of the eye.
struct MoveCount {
  std::size_t total = 0;       ///< tiles of the map after the move
  std::size_t difference = 0;  ///< those of them that the map before it did not have
};

/// A place from which neither 2^17 moves nor the tiles of K <= 9 levels reach a border of the world, so that
/// it has none; a corner of the tiles of all those levels.
TileId endless_world();

/// The tiles that a map of the spec shows with the eye there, its K levels only.
std::vector<TileId> counted_tiles(const CountSpec& spec, const TileId& eye);

/// A walk from the start: one count a move.
std::vector<MoveCount> count_walk(const CountSpec& spec, std::span<const Move> walk);

/// Every eye tile of a 2^(K+2) square north-east of the start, and from each every one of `moves`.
std::vector<MoveCount> count_exhaustively(const CountSpec& spec, std::span<const Move> moves);

}  // namespace cairn
