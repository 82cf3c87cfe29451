// Tables of places as programs write them, through `cairn sample --points`.

#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

using nlohmann::json;
using test::run_cairn;

/// Metres above -178 E, -89 N on a plane (quantum 0.25 m): 768 m per degree east, 1280 m per degree north.
std::int32_t tilted(std::int64_t column, std::int64_t row) {
  return static_cast<std::int32_t>(3 * (column - 2048) + 5 * (row - 1024));
}
const test::TestSurface kTilted{257, 2, tilted, {}};

struct PackFile {
  PackFile() { test::write_test_pack(path, kTilted, test::with_ancestors({{2, 8, 4}, {2, 9, 4}}, 0)); }
  test::TempDir dir;
  std::filesystem::path path = dir.path() / "a.cairn";

  test::Ran sample(const std::string& table, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"sample", path.string(), "--points", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_cairn(arguments, table);
  }
};

}  // namespace

TEST_CASE("tables are read whatever separates their fields and names their columns") {
  const PackFile pack;
  // Two places: 192 m and 96 + 160 = 256 m.
  struct Table {
    const char* text;
    const char* out;
  };
  for (const Table& t : std::initializer_list<Table>{
           {"\xEF\xBB\xBFlon,lat\n-177.75,-89\n-177.875,-88.875\n",
            "lon,lat,height,level\n-177.75,-89,192.0000,2\n-177.875,-88.875,256.0000,2\n"},
           {"Longitude,Latitude\r\n-177.75,-89\r\n-177.875,-88.875\r\n",
            "lon,lat,height,level\n-177.75,-89,192.0000,2\n-177.875,-88.875,256.0000,2\n"},
           {"name;Y;X\n\"Ridge; east\";-89;-177.75\nb;-88.875;-177.875\n",
            "lon;lat;height;level;name\n-177.75;-89;192.0000;2;\"Ridge; "
            "east\"\n-177.875;-88.875;256.0000;2;b\n"},
           {"x;y;z\n-177,75;-89,0;1,5\n-177,875;-88,875;2\n",
            "lon;lat;height;level;z\n-177,75;-89,0;192,0000;2;1,5\n-177,875;-88,875;256,0000;2;2\n"},
           {"-177.75 -89 10\n-177.875   -88.875  20 \n",
            "lon,lat,height,level,column3\n-177.75,-89,192.0000,2,10\n-177.875,-88.875,256.0000,2,20\n"},
           {"id\tLON\tLAT\n\t-177.75\t-89\n7\t-177.875\t-88.875\n",
            "lon\tlat\theight\tlevel\tid\n-177.75\t-89\t192.0000\t2\t\n-177.875\t-88.875\t256.0000\t2\t7\n"},
           {"\"lat\",\"a \"\"b\"\"\",\"lon\"\n-89,\"1,5\",-177.75\n-88.875,,-177.875\n",
            "lon,lat,height,level,\"a "
            "\"\"b\"\"\"\n-177.75,-89,192.0000,2,\"1,5\"\n-177.875,-88.875,256.0000,2,\n"},
       }) {
    const auto ran = pack.sample(t.text);
    INFO(t.text << ran.err);
    CHECK(ran.exit_code == 0);
    CHECK(ran.out == t.out);
    CHECK(ran.err.empty());
  }
}

TEST_CASE("the columns of the place can be named, and names that are none are an error") {
  const PackFile pack;
  const char* table = "Rechts,Hoch\n-177.75,-89\n";
  const auto unnamed = pack.sample(table);
  CHECK(unnamed.exit_code == 3);
  CHECK(test::is_one_line(unnamed.err));
  CHECK_THAT(unnamed.err, Catch::Contains("expected columns lon,lat") && Catch::Contains("Rechts,Hoch"));
  CHECK(pack.sample(table, {"--columns", "rechts,hoch"}).out ==
        "lon,lat,height,level\n-177.75,-89,192.0000,2\n");
  CHECK(pack.sample(table, {"--columns", "rechts,links"}).exit_code == 3);
  CHECK(pack.sample("-177.75,-89\n", {"--columns", "a,b"}).exit_code == 3);
  CHECK(pack.sample(table, {"--columns", "a"}).exit_code == 2);
}

TEST_CASE("a line without a place is named and passed over, and the exit status says so") {
  const PackFile pack;
  const auto ran = pack.sample("lon,lat,id\n-177.75,-89,a\nnan,-89,b\n-177.75\n-177.875,-88.875,d\n");
  CHECK(ran.exit_code == 3);
  CHECK(ran.out ==
        "lon,lat,height,level,id\n-177.75,-89,192.0000,2,a\nnan,-89,,,b\n-177.75,,,,\n"
        "-177.875,-88.875,256.0000,2,d\n");
  CHECK_THAT(ran.err, Catch::Contains("line 3: expected two numbers lon,lat, found nan,-89,b\n") &&
                          Catch::Contains("line 4: expected two numbers lon,lat, found -177.75\n"));
  std::string many = "lon,lat\n";
  for (int i = 0; i < 25; ++i) many += "x,y\n";
  const auto bad = pack.sample(many);
  CHECK(bad.exit_code == 3);
  CHECK_THAT(bad.err, Catch::Contains("line 11: ") && Catch::Contains("15 more lines"));
  CHECK_THAT(bad.err, !Catch::Contains("line 12: "));
}

TEST_CASE("JSON has the other columns by their names") {
  const PackFile pack;
  const json array = json::parse(pack.sample("id,lon,lat\n7,-177.75,-89\n8,?,1\n", {"--json"}).out);
  REQUIRE(array.size() == 2);
  CHECK(array[0]["height"] == 192.0);
  CHECK(array[0]["columns"] == json{{"id", "7"}});
  CHECK(array[1]["lon"].is_null());
}

TEST_CASE("text that is not UTF-8's is refused or passed on, and no bytes make the reader crash") {
  const PackFile pack;
  const auto wide = pack.sample(std::string("\xFF\xFEl\0o\0n\0", 8));
  CHECK(wide.exit_code == 3);
  CHECK_THAT(wide.err, Catch::Contains("UTF-16"));
  CHECK(pack.sample("").out == "lon,lat,height,level\n");
  for (const char* odd :
       {"\"", "\"\"\"", ",", ";;;", "\t", " ", "lon,lat\n\"1,2", "\xff\n", "lon\n", "1,2,\"a\"b\"c\n"}) {
    const auto ran = pack.sample(odd);
    INFO(odd);
    CHECK((ran.exit_code == 0 || ran.exit_code == 3));
  }
}

}  // namespace cairn
