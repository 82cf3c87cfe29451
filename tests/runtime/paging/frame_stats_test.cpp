#include "runtime/paging/frame_stats.h"

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("percentiles are measurements, by nearest rank") {
  std::vector<double> samples;
  for (int i = 100; i >= 1; --i) samples.push_back(i);
  const Summary s = summarize(samples);
  CHECK(s.count == 100);
  CHECK(s.min == 1);
  CHECK(s.max == 100);
  CHECK(s.mean == Approx(50.5));
  CHECK(s.p50 == 50);
  CHECK(s.p95 == 95);
  CHECK(s.p99 == 99);
}

TEST_CASE("one measurement is all its percentiles and none gives zeros") {
  CHECK(summarize({7}).p50 == 7);
  CHECK(summarize({7}).p99 == 7);
  CHECK(summarize({}).count == 0);
  CHECK(summarize({}).max == 0);
}

}  // namespace cairn
