#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

/// One move of the camera, in tiles of the finest level.
struct Move {
  std::int32_t dx = 0;
  std::int32_t dy = 0;
};

/// Returns the one-tile moves of a kind: axis (4), diagonal (4) or random (all 8); none for another word.
std::span<const Move> moves_of_kind(std::string_view kind);

/// Returns `count` moves drawn from `kinds`. Equal seeds give equal moves on every machine. REQUIRES: kinds
/// is not empty.
std::vector<Move> random_walk(std::span<const Move> kinds, std::size_t count, std::uint64_t seed);

/// Reads a walk from a text file with one move per line, "dx,dy"; empty lines and those that begin with # are
/// skipped. bad_data names the first line that is no move.
Result<std::vector<Move>> read_walk(const std::filesystem::path& path);

/// Returns the tile that a move leads to; a move beyond a pole stays where it is.
TileId moved(const TileId& eye, const Move& move);

}  // namespace cairn
