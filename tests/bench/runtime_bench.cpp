// cairn-runtime-bench PACK: what the runtime's steps take, on the wall clock, with p50, p95 and p99.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <thread>

#include <time.h>

#include "cairn/terrain.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/stats/block_count.h"
#include "runtime/stats/pack_walk.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// What another program on the machine cannot lengthen much.
double process_cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

void print(const char* what, const char* unit, const std::vector<double>& samples) {
  const Summary s = summarize(samples);
  std::printf("%-58s %6zu x  p50 %8.2f  p95 %8.2f  p99 %8.2f  %s\n", what, s.count, s.p50, s.p95, s.p99,
              unit);
}

template <class Work>
std::vector<double> time_each(int count, Work work) {
  std::vector<double> samples;
  for (int i = 0; i < count; ++i) {
    const auto start = Clock::now();
    work(i);
    samples.push_back(microseconds_since(start));
  }
  return samples;
}

void bench_scene_map(const TileAvailability& contents, const TileId& middle) {
  const auto eye = [](const TileId& from, int i) { return neighbour_of(from, i % 97, i % 89); };
  const TileId endless = endless_world();
  std::size_t tiles = 0;
  print("scene map, K = 4, every tile there", "us", time_each(20000, [&](int i) {
          tiles += build_scene_map({eye(endless, i), endless.level - 3}).size();
        }));
  const HasTile has = [&](const TileId& id) { return contents.shows(id); };
  if (middle.level - 3 >= kMinLevel) {
    print("scene map, K = 4, looked up in the pack", "us", time_each(20000, [&](int i) {
            tiles += build_scene_map({eye(middle, i % 3), middle.level - 3}, has).size();
          }));
  }
  print("scene map, whole Earth, looked up in the pack", "us",
        time_each(20000, [&](int i) { tiles += build_scene_map({eye(middle, i % 3)}, has).size(); }));
  if (tiles == 0) std::abort();  // and so the maps cannot be optimised away
}

Status bench_loading(const std::shared_ptr<const PackReader>& pack, int workers) {
  std::vector<IndexEntry> stored;
  for (std::size_t i = 0; i < pack->entry_count(); ++i) {
    const IndexEntry entry = pack->entry(i);
    if (entry.layer == Layer::heights && entry.bytes > 0) stored.push_back(entry);
  }
  TimedLoader loader(read_from(pack), workers, pack->header().tile_size);
  std::vector<double> samples;
  double cpu_ms = 0;
  for (std::size_t run = 0; run < 300; ++run) {
    std::vector<IndexEntry> ten;
    for (std::size_t i = 0; i < 10; ++i) ten.push_back(stored[(run * 7 + i) % stored.size()]);
    const double cpu_before_ms = process_cpu_ms();
    const auto load = loader.load(ten);
    if (!load) return load.error();
    if (run < 20) continue;  // until the page cache is warm
    samples.push_back(load->latency_ms);
    cpu_ms += process_cpu_ms() - cpu_before_ms;
  }
  const std::string what = "10 blocks of " + std::to_string(pack->header().tile_size) +
                           "^2 heights, request to ready, workers: " + std::to_string(workers);
  print(what.c_str(), "ms", samples);
  std::printf("  and of CPU time, all threads, a block: %.2f ms\n",
              cpu_ms / 10 / static_cast<double>(samples.size()));
  return {};
}

Status bench_update(const std::shared_ptr<const PackReader>& pack, const TileId& middle) {
  Result<Terrain> terrain = Terrain::open(pack);
  if (!terrain) return terrain.error();
  const GeoBounds bounds = tile_bounds(middle);
  ViewState view;
  view.eye = {(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2};
  view.height_m = 5000;
  view.pitch_deg = -20;
  while (!terrain->update(view, 0.01).is_complete) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::printf("the eye's map: %zu tiles, %.0f MiB\n", terrain->update(view, 0.01).tiles.size(),
              static_cast<double>(terrain->stats().resident_bytes) / (1 << 20));
  print("update() with nothing to load", "us", time_each(20000, [&](int i) {
          view.heading_deg = i % 360;
          terrain->update(view, 0.01);
        }));
  // Back and forth over the pack, a tile of the finest level every tenth frame.
  std::vector<double> samples;
  const std::uint64_t before = terrain->stats().moves;
  for (int i = 0; i < 2000; ++i) {
    view.eye.lon += (i / 40 % 2 == 0 ? 0.1 : -0.1) * bounds.width();
    const auto start = Clock::now();
    terrain->update(view, 1.0 / 60);
    samples.push_back(microseconds_since(start));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  print("update() in flight, a tile every ten frames", "us", samples);
  const PagingStats stats = terrain->stats();
  std::printf(
      "that flight: %llu moves, %llu tiles and %.1f MiB loaded, latency p50 %.2f p95 %.2f p99 %.2f ms\n",
      static_cast<unsigned long long>(stats.moves - before),
      static_cast<unsigned long long>(stats.tiles_loaded),
      static_cast<double>(stats.bytes_loaded) / (1 << 20), stats.latency_ms.p50, stats.latency_ms.p95,
      stats.latency_ms.p99);
  return {};
}

/// Ten thousand moves in random directions and at random altitudes about the middle of the pack, a
/// millisecond apart, so that loading is mostly behind.
Status bench_random_flight(const std::shared_ptr<const PackReader>& pack, const TileId& middle, int workers) {
  TerrainOptions options;
  options.workers = workers;
  options.cache_bytes = std::uint64_t{160} << 20;
  Result<Terrain> terrain = Terrain::open(pack, options);
  if (!terrain) return terrain.error();
  std::mt19937_64 random(5);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const GeoBounds bounds = tile_bounds(middle);
  const double width = bounds.width();
  ViewState view;
  view.eye = {bounds.west, bounds.south};
  std::uint64_t most_bytes = 0;
  std::vector<double> samples;
  for (int i = 0; i < 10000; ++i) {
    if (i % 50 == 0) view.height_m = std::exp(between(std::log(500.0), std::log(1e6)));
    view.eye.lon = std::clamp(view.eye.lon + between(-width, width) / 4, bounds.west - 8 * width,
                              bounds.east + 8 * width);
    view.eye.lat = std::clamp(view.eye.lat + between(-width, width) / 4, bounds.south - 8 * width,
                              bounds.north + 8 * width);
    const auto start = Clock::now();
    terrain->update(view, 1.0 / 60);
    samples.push_back(microseconds_since(start));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (i % 10 == 0) {
      const PagingStats stats = terrain->stats();
      most_bytes = std::max(most_bytes, stats.resident_bytes + stats.in_flight_bytes);
    }
  }
  print("update() in 10000 random moves", "us", samples);
  const PagingStats stats = terrain->stats();
  std::printf(
      "  workers %d: %llu map changes, %llu tiles loaded, %llu stale, %llu withdrawn, holes %llu, "
      "tiles took %.0f MiB of %.0f at most\n",
      workers, static_cast<unsigned long long>(stats.moves),
      static_cast<unsigned long long>(stats.tiles_loaded), static_cast<unsigned long long>(stats.tiles_stale),
      static_cast<unsigned long long>(stats.tiles_withdrawn), static_cast<unsigned long long>(stats.holes),
      static_cast<double>(most_bytes) / (1 << 20), static_cast<double>(options.cache_bytes) / (1 << 20));
  return {};
}

Status run(const char* path) {
  Result<PackReader> opened = PackReader::open(path);
  if (!opened) return opened.error();
  const auto pack = std::make_shared<const PackReader>(std::move(*opened));
  const auto middle = middle_tile(*pack);
  if (!middle) return bad_data(std::string(path) + ": expected tiles of heights, found none");
  std::printf("pack: %zu tiles, finest level %d\n", pack->entry_count(), middle->level);
  bench_scene_map(TileAvailability(pack), *middle);
  for (const int workers : {1, 2, 4}) {
    if (const Status status = bench_loading(pack, workers); !status) return status;
  }
  if (const Status status = bench_update(pack, *middle); !status) return status;
  for (const int workers : {1, 2, 4}) {
    if (const Status status = bench_random_flight(pack, *middle, workers); !status) return status;
  }
  return {};
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: cairn-runtime-bench PACK\n");
    return 2;
  }
  const cairn::Status status = cairn::run(argv[1]);
  if (status) return 0;
  std::fprintf(stderr, "cairn-runtime-bench: %s\n", status.error().message.c_str());
  return static_cast<int>(status.error().code);
}
