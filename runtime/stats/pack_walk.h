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

/// Loads tiles of a pack on worker threads and measures the time from the request to the last decoded tile.
class TimedLoader {
 public:
  /// REQUIRES: workers >= 1.
  TimedLoader(ReadTile read, int workers, int tile_size) : loader_(std::move(read), workers, tile_size) {}

  /// Waits for all tiles. Returns the first error if there was one.
  Result<MoveLoad> load(std::span<const IndexEntry> tiles);

 private:
  TileLoader loader_;
};

/// Returns a tile in the middle of the pack's finest heights; nullopt if the pack has none.
std::optional<TileId> middle_tile(const PackReader& pack);

/// Returns the walk with every move kept over tiles of the start's level: a move off them goes the other way,
/// or nowhere if that is off them too.
std::vector<Move> kept_inside(std::span<const Move> walk, const TileId& start, const HasTile& has);

/// Loads each move's difference blocks, given the tiles that are shown before the first move and after each.
/// Returns one load per move.
Result<std::vector<MoveLoad>> load_walk(std::span<const std::vector<TileId>> shown, const PackReader& pack,
                                        TimedLoader& loader);

/// The time to load some blocks, without and with roughness_of() (Melkisetoğlu 2005, figure 8.2.1).
struct LoadingTime {
  std::size_t blocks = 0;
  double plain_ms = 0;
  double roughness_ms = 0;
};
/// Returns the times for 1 to `most` blocks, each the shortest of five runs.
Result<std::vector<LoadingTime>> time_loading(const std::shared_ptr<const PackReader>& pack, std::size_t most,
                                              int workers);

/// Returns rows blocks,plain_ms,roughness_ms.
std::string to_csv(std::span<const LoadingTime> times);

}  // namespace cairn
