#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cairn/pack_reader.h"
#include "runtime/paging/tile_loader.h"
#include "runtime/stats/block_count.h"
#include "runtime/stats/report.h"

namespace cairn {

/// Loads tiles of a pack on worker threads and times it, from the request to the last tile decoded.
class TimedLoader {
 public:
  /// REQUIRES: workers >= 1.
  TimedLoader(ReadTile read, int workers, int tile_size) : loader_(std::move(read), workers, tile_size) {}

  /// Waits for all of them. The first error if there was one.
  Result<MoveLoad> load(std::span<const IndexEntry> tiles);

 private:
  TileLoader loader_;
};

/// A tile in the middle of the pack's finest heights; nullopt where it has none.
std::optional<TileId> middle_tile(const PackReader& pack);

/// The walk turned into moves that stay over tiles of the start's level: a move off them goes the other way,
/// or nowhere if that is off them too.
std::vector<Move> kept_inside(std::span<const Move> walk, const TileId& start, const HasTile& has);

/// Loads what each move of a walk has to load. One load a move.
Result<std::vector<MoveLoad>> load_walk(const CountSpec& spec, std::span<const Move> walk,
                                        const PackReader& pack, TimedLoader& loader);

/// Loading 1…most blocks, [4, figure 8.2.1]: the shortest of five runs each, plainly and with the roughness
/// calculation of Röttger et al. that the thesis compares with.
struct LoadingTime {
  std::size_t blocks = 0;
  double plain_ms = 0;
  double roughness_ms = 0;
};
Result<std::vector<LoadingTime>> time_loading(const std::shared_ptr<const PackReader>& pack, std::size_t most,
                                              int workers);

/// blocks,plain_ms,roughness_ms
std::string to_csv(std::span<const LoadingTime> times);

}  // namespace cairn
