#include "tests/support/synthetic_relief.h"

#include <algorithm>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("Windows of the synthetic relief agree wherever they overlap") {
  const bench::SyntheticRelief relief(4096, 1);
  constexpr int kSize = 300;
  const std::int64_t x = 40 * 4096, y = 37 * 4096;
  std::vector<std::int16_t> whole(kSize * kSize);
  relief.heights(x, y, kSize, kSize, whole);
  CHECK(*std::max_element(whole.begin(), whole.end()) > *std::min_element(whole.begin(), whole.end()));
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const int c = static_cast<int>(random() % kSize), r = static_cast<int>(random() % kSize);
    const int columns = 1 + static_cast<int>(random() % static_cast<unsigned>(kSize - c));
    const int rows = 1 + static_cast<int>(random() % static_cast<unsigned>(kSize - r));
    std::vector<std::int16_t> part(static_cast<std::size_t>(columns * rows));
    relief.heights(x + c, y + r, columns, rows, part);
    bool equal = true;
    for (int k = 0; k < rows; ++k)
      equal = equal && std::equal(part.begin() + k * columns, part.begin() + (k + 1) * columns,
                                  whole.begin() + (r + k) * kSize + c);
    CHECK(equal);
  }
}

}  // namespace cairn
