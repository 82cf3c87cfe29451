#include "runtime/stats/block_count.h"

namespace cairn {

TileId endless_world() {
  return {kMaxLevel, 180 << kMaxLevel, 90 << kMaxLevel};
}

std::vector<TileId> counted_tiles(const CountSpec& spec, const TileId& eye) {
  return sources_of(
      build_scene_map({eye, eye.level - spec.levels + 1, spec.pattern, spec.window_tiles}, spec.has));
}

std::vector<MoveCount> count_walk(const CountSpec& spec, std::span<const Move> walk) {
  std::vector<MoveCount> counts;
  counts.reserve(walk.size());
  TileId eye = spec.start;
  std::vector<TileId> here = counted_tiles(spec, eye);
  for (const Move& move : walk) {
    eye = moved(eye, move);
    std::vector<TileId> there = counted_tiles(spec, eye);
    counts.push_back({there.size(), difference(here, there).size()});
    here = std::move(there);
  }
  return counts;
}

std::vector<MoveCount> count_exhaustively(const CountSpec& spec, std::span<const Move> moves) {
  const std::int32_t side = 1 << (spec.levels + 2);
  std::vector<MoveCount> counts;
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const TileId eye = neighbour_of(spec.start, x, y);
      const std::vector<TileId> here = counted_tiles(spec, eye);
      for (const Move& move : moves) {
        const std::vector<TileId> there = counted_tiles(spec, moved(eye, move));
        counts.push_back({there.size(), difference(here, there).size()});
      }
    }
  }
  return counts;
}

}  // namespace cairn
