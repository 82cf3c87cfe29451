#include "runtime/stats/block_count.h"

namespace cairn {

TileId endless_world() {
  return {kMaxLevel, 180 << kMaxLevel, 90 << kMaxLevel};
}

std::vector<TileId> counted_tiles(const CountSpec& spec, const TileId& eye) {
  return sources_of(
      build_scene_map({eye, eye.level - spec.levels + 1, spec.pattern, spec.window_tiles}, spec.has));
}

std::vector<std::vector<TileId>> shown_along(const CountSpec& spec, std::span<const Move> walk) {
  TileId eye = spec.start;
  std::vector<std::vector<TileId>> shown{counted_tiles(spec, eye)};
  for (const Move& move : walk) {
    eye = moved(eye, move);
    shown.push_back(counted_tiles(spec, eye));
  }
  return shown;
}

std::vector<MoveCount> count_moves(std::span<const std::vector<TileId>> shown) {
  std::vector<MoveCount> counts;
  for (std::size_t i = 1; i < shown.size(); ++i) {
    counts.push_back({shown[i].size(), difference(shown[i - 1], shown[i]).size()});
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
