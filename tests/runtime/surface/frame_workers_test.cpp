#include "runtime/surface/frame_workers.h"

#include <atomic>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("every item of a frame's work is done once, before run() returns, on any number of threads") {
  for (const int threads : {0, 1, 4}) {
    FrameWorkers workers(threads);
    for (std::size_t frame = 0; frame < 300; ++frame) {
      const std::size_t count = frame % 37;
      std::vector<int> done(count);
      std::atomic<std::size_t> calls = 0;
      workers.run(count, [&](std::size_t i) {
        done[i] += 1;
        ++calls;
      });
      REQUIRE(calls == count);
      REQUIRE(done == std::vector<int>(count, 1));
    }
  }
}

TEST_CASE("workers that were never asked for anything end") {
  const FrameWorkers workers(3);
}

}  // namespace cairn
