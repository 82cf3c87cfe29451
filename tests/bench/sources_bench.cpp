// cairn-sources-bench: how fast a raster is read in windows of 513×513 posts, as a bake reads it, by one and
// by several threads. Prints posts a second of CPU time, which does not depend on what else the machine does.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <time.h>

#include "builder/raster/raster_source.h"

namespace {

constexpr std::int64_t kWindow = 513;

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double wall_seconds() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Measured {
  std::int64_t posts = 0;
  double cpu_seconds = 0;
  bool ok = true;
};

/// Reads every window once, the threads taking turns.
Measured read_all(const cairn::RasterSource& source, int threads) {
  const auto& info = source.info();
  const std::int64_t across = (info.columns + kWindow - 2) / (kWindow - 1),
                     down = (info.rows + kWindow - 2) / (kWindow - 1);
  std::atomic<std::int64_t> next = 0;
  std::vector<Measured> parts(static_cast<std::size_t>(threads));
  const auto work = [&](Measured& part) {
    std::vector<float> heights(kWindow * kWindow);
    const double start = thread_seconds();
    for (std::int64_t i = next++; i < across * down; i = next++) {
      const std::int64_t column = i % across * (kWindow - 1), row = i / across * (kWindow - 1);
      const cairn::PostWindow window{column, row, std::min(kWindow, info.columns - column),
                                     std::min(kWindow, info.rows - row)};
      const auto count = static_cast<std::size_t>(window.columns * window.rows);
      part.ok = part.ok && source.read_heights(window, std::span(heights).first(count)).ok();
      part.posts += window.columns * window.rows;
    }
    part.cpu_seconds = thread_seconds() - start;
  };
  {
    std::vector<std::jthread> workers;
    for (Measured& part : parts) workers.emplace_back(work, std::ref(part));
  }
  Measured all;
  for (const Measured& part : parts) {
    all.posts += part.posts;
    all.cpu_seconds += part.cpu_seconds;
    all.ok = all.ok && part.ok;
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: cairn-sources-bench RASTER...\n");
    return 2;
  }
  for (int i = 1; i < argc; ++i) {
    const auto source = cairn::open_raster(argv[i], {});
    if (!source) {
      fmt::print(stderr, "{}\n", source.error().message);
      return 3;
    }
    for (const int threads : {1, 2, 4}) {
      double best_cpu = 1e9, best_wall = 1e9;
      std::int64_t posts = 0;
      for (int run = 0; run < 3; ++run) {
        const double start = wall_seconds();
        const Measured m = read_all(**source, threads);
        if (!m.ok) return 1;
        best_wall = std::min(best_wall, wall_seconds() - start);
        best_cpu = std::min(best_cpu, m.cpu_seconds);
        posts = m.posts;
      }
      fmt::print("{}: {} threads: {:.0f} Mposts/s of CPU, {:.0f} Mposts/s of time\n", argv[i], threads,
                 static_cast<double>(posts) / best_cpu / 1e6, static_cast<double>(posts) / best_wall / 1e6);
    }
  }
  return 0;
}
