#include "runtime/stats/pack_walk.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

#include "runtime/stats/roughness.h"

namespace cairn {
namespace {

constexpr int kRuns = 5;
constexpr std::chrono::microseconds kPoll{50};

/// Tiles with blocks of their own, the finest first.
std::vector<IndexEntry> stored_tiles(const PackReader& pack, std::size_t most) {
  std::vector<IndexEntry> tiles;
  for (std::size_t i = pack.entry_count(); i-- > 0 && tiles.size() < most;) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::heights && entry.bytes > 0) tiles.push_back(entry);
  }
  return tiles;
}

/// The shortest of a few runs: whatever else the machine does only lengthens them.
Result<double> shortest_ms(TimedLoader& loader, std::span<const IndexEntry> tiles) {
  std::vector<double> runs;
  for (int run = 0; run < kRuns; ++run) {
    const Result<MoveLoad> load = loader.load(tiles);
    if (!load) return load.error();
    runs.push_back(load->latency_ms);
  }
  return summarize(runs).min;
}

}  // namespace

Result<MoveLoad> TimedLoader::load(std::span<const IndexEntry> tiles) {
  const auto start = std::chrono::steady_clock::now();
  MoveLoad load;
  for (const IndexEntry& tile : tiles) {
    load.bytes += tile.bytes;
    loader_.submit(tile);
  }
  std::optional<Error> error;
  for (std::size_t done = 0; done < tiles.size();) {
    const auto results = loader_.take(UINT64_MAX);
    done += results.size();
    for (const LoadResult& result : results) {
      if (!result.tile && !error) error = result.tile.error();
    }
    if (results.empty()) std::this_thread::sleep_for(kPoll);
  }
  if (error) return *error;
  load.latency_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return load;
}

std::optional<TileId> middle_tile(const PackReader& pack) {
  const auto levels = pack.levels(Layer::heights);
  if (!levels) return std::nullopt;
  std::vector<TileId> finest;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::heights && entry.id.level == levels->finest) finest.push_back(entry.id);
  }
  return finest[finest.size() / 2];
}

std::vector<Move> kept_inside(std::span<const Move> walk, const TileId& start, const HasTile& has) {
  std::vector<Move> kept;
  kept.reserve(walk.size());
  TileId eye = start;
  for (Move move : walk) {
    if (!has(moved(eye, move))) move = {-move.dx, -move.dy};
    if (!has(moved(eye, move))) move = {0, 0};
    eye = moved(eye, move);
    kept.push_back(move);
  }
  return kept;
}

Result<std::vector<MoveLoad>> load_walk(std::span<const std::vector<TileId>> shown, const PackReader& pack,
                                        TimedLoader& loader) {
  std::vector<MoveLoad> loads;
  for (std::size_t i = 1; i < shown.size(); ++i) {
    std::vector<IndexEntry> entries;
    for (const TileId& id : difference(shown[i - 1], shown[i]))
      entries.push_back(*pack.find(Layer::heights, id));
    const Result<MoveLoad> load = loader.load(entries);
    if (!load) return load.error();
    loads.push_back(*load);
  }
  return loads;
}

Result<std::vector<LoadingTime>> time_loading(const std::shared_ptr<const PackReader>& pack, std::size_t most,
                                              int workers) {
  const std::vector<IndexEntry> tiles = stored_tiles(*pack, most);
  const ReadTile read = read_from(pack);
  const int tile_size = pack->header().tile_size;
  TimedLoader plain(read, workers, tile_size);
  TimedLoader with_roughness(
      [read](const IndexEntry& entry) {
        Result<LoadedTile> tile = read(entry);
        if (tile) roughness_of(*tile->heights);
        return tile;
      },
      workers, tile_size);
  std::vector<LoadingTime> times;
  for (std::size_t blocks = 1; blocks <= tiles.size(); ++blocks) {
    const std::span<const IndexEntry> some = std::span(tiles).first(blocks);
    const Result<double> plain_ms = shortest_ms(plain, some);
    if (!plain_ms) return plain_ms.error();
    const Result<double> roughness_ms = shortest_ms(with_roughness, some);
    if (!roughness_ms) return roughness_ms.error();
    times.push_back({blocks, *plain_ms, *roughness_ms});
  }
  return times;
}

std::string to_csv(std::span<const LoadingTime> times) {
  std::ostringstream out;
  out << "blocks,plain_ms,roughness_ms\n";
  for (const LoadingTime& time : times) {
    out << time.blocks << "," << time.plain_ms << "," << time.roughness_ms << "\n";
  }
  return out.str();
}

}  // namespace cairn
