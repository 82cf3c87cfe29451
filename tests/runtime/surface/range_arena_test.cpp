#include "runtime/surface/range_arena.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("ranges that are taken do not overlap, and a buffer whose ranges are all released is empty") {
  RangeArena arena;
  std::map<std::uint32_t, std::uint32_t> taken;
  std::mt19937 random(3);
  std::uint32_t in_use = 0, most_in_use = 0, largest_end = 0;
  for (int step = 0; step < 20000; ++step) {
    if (taken.size() < 200 || random() % 2 == 0) {
      const auto count = static_cast<std::uint32_t>(1 + random() % 3000);
      const auto [at, is_new] = taken.emplace(arena.take(count), count);
      REQUIRE(is_new);
      if (at != taken.begin()) REQUIRE(std::prev(at)->first + std::prev(at)->second <= at->first);
      if (std::next(at) != taken.end()) REQUIRE(at->first + count <= std::next(at)->first);
      REQUIRE(at->first + count <= arena.end());
      in_use += count;
    } else {
      const auto at = std::next(taken.begin(), static_cast<std::ptrdiff_t>(random() % taken.size()));
      arena.release(at->first, at->second);
      in_use -= at->second;
      taken.erase(at);
    }
    most_in_use = std::max(most_in_use, in_use);
    largest_end = std::max(largest_end, arena.end());
  }
  CHECK(largest_end < 2 * most_in_use);
  for (const auto& [first, count] : taken) arena.release(first, count);
  CHECK(arena.end() == 0);
  CHECK(arena.take(0) == 0);
  CHECK(arena.end() == 0);
}

}  // namespace cairn
