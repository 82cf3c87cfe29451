#pragma once

#include <cstdint>
#include <vector>

#include "builder/heights/error_stats.h"
#include "cairn/height_tile.h"
#include "cairn/status.h"
#include "cairn/tile_id.h"
#include "format/bytes.h"

namespace cairn {

/// A tile on its way up the tree, its descendants done.
struct HeightNode {
  TileId id;
  HeightTile tile;
  double filled = 0;  ///< share of its samples that no source gave

  /// errors_m[i]: how far the surface of level id.level - i is from the posts below this tile, never too
  /// small, for every level up to the plan's top. Decreasing detail never decreases it.
  std::vector<double> errors_m;

  /// Errors of the posts whose finest stored tile is known, measured there.
  ErrorStats final_stats;
  /// Errors of the other posts if their finest stored tile turns out to be the one at level id.level - i, by
  /// i. It goes as far up as tiles can be pruned.
  std::vector<ErrorStats> candidate_stats;
  bool edge_only = false;   ///< only its edge counts, for its parent: never stored, nothing measured
  bool has_stored = false;  ///< this tile or a descendant is stored

  /// By number in the RasterPool: how many of the posts that count are the source's.
  std::vector<std::uint64_t> posts_used;
  std::vector<std::uint64_t> posts_lost;  ///< by source: those over which another source won
};

/// For the journal: a finished subtree's root again after an interruption.
void append_height_node(const HeightNode& node, std::vector<std::byte>& out);
Result<HeightNode> read_height_node(ByteReader& in, int tile_size);

}  // namespace cairn
