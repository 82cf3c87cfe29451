// run_in_order(): the order, the bound and the errors, with tasks that end in any order.

#include "builder/bake/pipeline.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "builder/bake/thread_arena.h"

namespace cairn {
namespace {

constexpr int kThreads = 4;

void wait_a_little(std::size_t i) {
  std::this_thread::sleep_for(std::chrono::microseconds((i * 7919) % 13 * 100));
}

// Counts how many results are alive at once.
class Counted {
 public:
  Counted(std::size_t index, std::atomic<int>& alive, std::atomic<int>& most)
      : index_(index), alive_(&alive) {
    const int now = ++alive;
    int before = most;
    while (now > before && !most.compare_exchange_weak(before, now)) {
    }
  }
  Counted(Counted&& other) noexcept : index_(other.index_), alive_(std::exchange(other.alive_, nullptr)) {}
  Counted& operator=(Counted&&) = delete;
  ~Counted() {
    if (alive_ != nullptr) --*alive_;
  }
  std::size_t index() const { return index_; }

 private:
  std::size_t index_;
  std::atomic<int>* alive_;
};

}  // namespace

TEST_CASE("results are taken in order, and no more than the bound exist at once") {
  for (const std::size_t in_flight : {1u, 3u, 8u}) {
    std::atomic<int> alive = 0, most = 0;
    std::vector<std::size_t> taken;
    const auto status = with_threads(kThreads, [&](int) {
      return run_in_order<Counted>(
          5, 60, in_flight,
          [&](std::size_t i) -> Result<Counted> {
            wait_a_little(i);
            return Counted(i, alive, most);
          },
          [&](std::size_t i, Counted&& result) -> Status {
            taken.push_back(i);
            return result.index() == i ? Status() : failed("another's result");
          });
    });
    CHECK(status.ok());
    REQUIRE(taken.size() == 55);
    for (std::size_t k = 0; k < taken.size(); ++k) CHECK(taken[k] == k + 5);
    CHECK(alive == 0);
    CHECK(most <= static_cast<int>(in_flight));
  }
}

TEST_CASE("the first error in order ends the run, whichever comes first in time") {
  for (const std::size_t bad : {0u, 7u, 29u}) {
    std::vector<std::size_t> taken;
    const auto status = with_threads(kThreads, [&](int) {
      return run_in_order<std::size_t>(
          0, 30, 8,
          [&](std::size_t i) -> Result<std::size_t> {
            if (i > bad) return failed("late " + std::to_string(i));  // all of these end sooner
            wait_a_little(i + 11);
            if (i == bad) return failed("first");
            return i;
          },
          [&](std::size_t i, std::size_t&&) -> Status {
            taken.push_back(i);
            return {};
          });
    });
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().message == "first");
    CHECK(taken.size() == bad);
  }
}

TEST_CASE("an error of the sink ends the run: nothing more is taken, and little more is begun") {
  std::atomic<std::size_t> begun = 0;
  std::size_t taken = 0;
  const auto status = with_threads(kThreads, [&](int) {
    return run_in_order<std::size_t>(
        0, 10000, 4,
        [&](std::size_t i) -> Result<std::size_t> {
          ++begun;
          return i;
        },
        [&](std::size_t, std::size_t&&) -> Status { return ++taken == 10 ? failed("full") : Status(); });
  });
  REQUIRE_FALSE(status.ok());
  CHECK(status.error().message == "full");
  CHECK(taken == 10);
  CHECK(begun <= 10 + 4);
}

TEST_CASE("a run of nothing succeeds") {
  const auto status = run_in_order<int>(
      3, 3, 2, [](std::size_t) -> Result<int> { return failed("work"); },
      [](std::size_t, int&&) -> Status { return failed("sink"); });
  CHECK(status.ok());
}

}  // namespace cairn
