#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

/// One move of the eye, in tiles of the finest level.
struct Move {
  std::int32_t dx = 0;
  std::int32_t dy = 0;
};

/// The one-tile moves of a kind: axis (4), diagonal (4) or random (all 8). Empty for another word.
std::span<const Move> moves_of_kind(std::string_view kind);

/// `count` moves drawn from `kinds`, the same on every machine for a seed. REQUIRES: kinds is not empty.
std::vector<Move> random_walk(std::span<const Move> kinds, std::size_t count, std::uint64_t seed);

/// A walk as text: a line a move, "dx,dy"; empty lines and those that begin with # are skipped. bad_data
/// names the first line that is not one.
Result<std::vector<Move>> read_walk(const std::filesystem::path& path);

/// Where a move leads; a move off the end of the world in latitude stays where it is.
TileId moved(const TileId& eye, const Move& move);

}  // namespace cairn
