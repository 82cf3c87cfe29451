// Any bytes are read as a table of places.
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

#include "builder/app/points_csv.h"
#include "tests/support/fuzz.h"

namespace cairn::test {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

void read_table(std::span<const std::byte> input) {
  std::istringstream in(std::string(reinterpret_cast<const char*>(input.data()), input.size()));
  PointsCsv csv(in, "t.csv");
  const auto points = csv.next(1000);
  if (!points) {
    REQUIRE(points.error().message.starts_with("t.csv: "));
    return;
  }
  std::size_t without_place = 0;
  for (const CsvPoint& point : *points) {
    REQUIRE(point.others.size() == csv.other_names().size());
    without_place += point.place ? 0 : 1;
  }
  REQUIRE(csv.complaints().size() == std::min<std::size_t>(without_place, 11));
}

}  // namespace

TEST_CASE("no bytes make reading a table of places crash, and each line has a place or a complaint") {
  run_fuzz("points_csv", read_table,
           {bytes_of("\xEF\xBB\xBFid,lon,lat\n1,2,3\n\"a \"\"b\"\"\",4,5\n"),
            bytes_of("x;y;z\n-1,5;2,5;3\n4;5;6\n"), bytes_of("1 2 3\n4 5 6\n"), bytes_of("lon\tlat\n1\t2\n")},
           3000);
}

}  // namespace cairn::test
