// The verbs that look at a pack: what they print, in text and JSON, and how they fail.

#include <filesystem>
#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "format/pack_writer.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::is_one_line;
using test::run_cairn;

/// A surface that bilinear sampling gives back exactly: metres above -178 E, -89 N (quantum 0.25 m).
std::int32_t tilted(std::int64_t column, std::int64_t row) {
  return static_cast<std::int32_t>(3 * (column - 2048) + 5 * (row - 1024));
}
double tilted_metres(double lon, double lat) {
  return (3 * (lon + 178) + 5 * (lat + 89)) * 1024 * 0.25;
}

const test::TestSurface kTilted{257, 2, tilted, {}};
const std::vector<TileId> kTiles = test::with_ancestors({{2, 8, 4}, {2, 9, 4}}, 0);

/// A pack in a folder of its own.
struct PackFile {
  test::TempDir dir;
  fs::path path = dir.path() / "a.cairn";
  std::string name() const { return path.string(); }
};

void damage(const fs::path& path, std::size_t at) {
  auto bytes = test::read_bytes(path);
  bytes[at] ^= std::byte{1};
  test::write_bytes(path, bytes);
}

}  // namespace

TEST_CASE("without arguments the program prints its help, and an unknown verb or option is wrong usage") {
  CHECK(run_cairn({}).exit_code == 0);
  CHECK_THAT(run_cairn({}).out, Catch::Contains("verify"));
  CHECK(run_cairn({"--help"}).exit_code == 0);
  CHECK_THAT(run_cairn({"--version"}).out, Catch::StartsWith("cairn "));
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"frobnicate"},
                                             {"../cairn"},
                                             {"info"},
                                             {"info", "a", "b"},
                                             {"info", "--frobnicate", "a"},
                                             {"--wrong"},
                                             {"sample", "a"},
                                             {"sample", "a", "1"},
                                             {"sample", "a", "1", "2", "--level", "99"},
                                             {"sample", "a", "1", "x"},
                                             {"sample", "a", "1", "2", "--points", "p"},
                                             {"verify", "a", "--threads", "-1"}}) {
    const auto ran = run_cairn(arguments);
    INFO(arguments.back() << ": " << ran.err);
    CHECK(ran.exit_code == 2);
    CHECK(ran.out.empty());
    CHECK(is_one_line(ran.err));
  }
}

TEST_CASE("every verb refuses what is no pack with one line that names the file") {
  const test::TempDir dir;
  const std::string missing = (dir.path() / "missing.cairn").string(),
                    garbage = (dir.path() / "garbage").string();
  std::ofstream(garbage) << std::string(5000, 'x');
  for (const std::string verb : {"info", "sample"}) {
    for (const auto& [file, exit_code] : {std::pair(missing, 1), {garbage, 3}}) {
      std::vector<std::string> arguments{verb, file};
      if (verb == "sample") arguments.insert(arguments.end(), {"1", "2"});
      const auto ran = run_cairn(arguments);
      CHECK(ran.exit_code == exit_code);
      CHECK(ran.out.empty());
      CHECK(is_one_line(ran.err));
      CHECK_THAT(ran.err, Catch::Contains(file));
    }
  }
  CHECK(run_cairn({"verify", missing}).exit_code == 1);
  CHECK(run_cairn({"verify", garbage}).exit_code == 3);
}

TEST_CASE("info prints the promised keys as JSON, and the same as text") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, kTiles);
  const auto ran = run_cairn({"info", pack.name(), "--json"});
  REQUIRE(ran.exit_code == 0);
  const json info = json::parse(ran.out);
  CHECK(info.at("format_version") == kPackVersion);
  CHECK(info.at("tile_size") == 257);
  CHECK(info.at("quantum_m") == 0.25);
  CHECK(info.at("vertical_datum") == "egm96");
  CHECK(info.at("bounds").at("west") == -178);
  CHECK(info.at("file_bytes") == fs::file_size(pack.path));
  REQUIRE(info.at("levels").size() == 3);
  CHECK(info.at("levels").at(2).at("level") == 2);
  CHECK(info.at("levels").at(2).at("tiles") == 2);
  CHECK(info.at("levels").at(2).at("constant_tiles") == 0);
  CHECK(info.at("levels").at(2).at("max_error_m") == 2.0);
  const double bytes = info.at("levels").at(2).at("bytes");
  CHECK(bytes > 0);
  CHECK(info.at("levels").at(2).at("bits_per_sample").get<double>() == Approx(bytes * 8 / (2 * 257 * 257)));
  CHECK(info.at("accuracy").at("p99_m") == 0.375);
  CHECK(info.at("accuracy").at("worst").at("lat") == -88.5);
  CHECK(info.at("sources").size() == 1);
  const auto text = run_cairn({"info", pack.name()});
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Catch::Contains("made.hgt") && Catch::Contains("257x257"));
}

TEST_CASE("verify says ok, or says what is wrong where and fails") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, kTiles);
  const auto good = run_cairn({"verify", pack.name(), "--json"});
  INFO(good.out);
  CHECK(good.exit_code == 0);
  CHECK(json::parse(good.out) == json{{"ok", true}, {"findings", json::array()}});
  damage(pack.path, kPackStartBytes + 30);
  const auto bad = run_cairn({"verify", pack.name(), "--json", "--threads", "2"});
  CHECK(bad.exit_code == 3);
  const json report = json::parse(bad.out);
  CHECK(report.at("ok") == false);
  REQUIRE(report.at("findings").size() == 1);
  CHECK(report.at("findings").at(0).at("where").get<std::string>().starts_with("heights "));
  CHECK_THAT(report.at("findings").at(0).at("what").get<std::string>(), Catch::Contains("checksum"));
  const auto text = run_cairn({"verify", pack.name()});
  CHECK(text.exit_code == 3);
  CHECK_THAT(text.out, Catch::Contains("1 findings"));
}

TEST_CASE("verify finds each way in which the metadata can break its promises") {
  const PackFile pack;
  const auto findings_with = [&](const std::function<void(json&)>& change) {
    Result<PackWriter> writer = PackWriter::create(pack.path, test::test_header());
    REQUIRE(writer.ok());
    json metadata = json::parse(test::test_metadata(test::test_header(), {}));
    change(metadata);
    REQUIRE(writer->finish(metadata.dump()).ok());
    std::string all;
    const json report = json::parse(run_cairn({"verify", pack.name(), "--json"}).out);
    for (const json& finding : report.at("findings")) {
      CHECK(finding.at("where") == "metadata");
      all += finding.at("what").get<std::string>() + "\n";
    }
    return all;
  };
  CHECK(findings_with([](json&) {}) == "");
  CHECK(findings_with([](json& m) { m = json::array(); }) == "expected a JSON object\n");
  for (const char* key :
       {"cairn", "vertical_datum", "error_bound_m", "bounds", "accuracy", "levels", "sources", "options"}) {
    CHECK_THAT(findings_with([&](json& m) { m.erase(key); }),
               Catch::StartsWith("/" + std::string(key) + ": expected"));
  }
  CHECK_THAT(findings_with([](json& m) { m["sources"] = 5; }),
             Catch::Contains("expected array, found number"));
  CHECK_THAT(findings_with([](json& m) { m["vertical_datum"] = "mars"; }),
             Catch::Contains("expected egm96, found mars"));
  CHECK_THAT(findings_with([](json& m) { m["grid"]["tile_size"] = 513; }),
             Catch::Contains("expected 257, found 513"));
  CHECK_THAT(findings_with([](json& m) { m["grid"]["quantum_m"] = 1; }),
             Catch::Contains("expected 0.25, found 1"));
  CHECK_THAT(findings_with([](json& m) { m["bounds"]["west"] = 20; }),
             Catch::Contains("expected an area of the Earth"));
  CHECK_THAT(findings_with([](json& m) { m["bounds"]["north"] = 91; }),
             Catch::Contains("expected an area of the Earth"));
  CHECK_THAT(findings_with([](json& m) { m["accuracy"]["p95_m"] = 9; }), Catch::Contains("p95 <= p99"));
  CHECK_THAT(findings_with([](json& m) { m["accuracy"]["worst"].erase("lon"); }),
             Catch::Contains("/accuracy/worst/lon"));
  CHECK_THAT(findings_with([](json& m) { m["levels"] = {1}; }), Catch::Contains("/levels: expected 0"));
}

TEST_CASE("verify finds levels in the metadata that are not the index's") {
  const PackFile pack;
  Result<PackWriter> writer = PackWriter::create(pack.path, test::test_header());
  REQUIRE(writer.ok());
  IndexEntry entry;
  entry.flags = kConstant;
  entry.geometric_error_m = 4;
  REQUIRE(writer->add(entry, {}).ok());
  const std::vector<PackLevel> others{{Layer::heights, entry.id.level, 5, 1, 1, 0}};
  REQUIRE(writer->finish(test::test_metadata(test::test_header(), others)).ok());
  CHECK_THAT(run_cairn({"verify", pack.name()}).out,
             Catch::Contains("/levels/0/max_error_m: expected 4, found 5"));
}

TEST_CASE("sample prints one height, or nothing where there is none") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, kTiles);
  const auto inside = run_cairn({"sample", pack.name(), "-177.7", "-88.8"});
  CHECK(inside.exit_code == 0);
  CHECK(std::stod(inside.out) == Approx(tilted_metres(-177.7, -88.8)).margin(1e-3));
  CHECK(run_cairn({"sample", pack.name(), "10", "10"}).out == "\n");
  const json found = json::parse(run_cairn({"sample", pack.name(), "-177.7", "-88.8", "--json"}).out);
  CHECK(found.at("level") == 2);
  CHECK(found.at("height").get<double>() == Approx(tilted_metres(-177.7, -88.8)).margin(1e-6));
  const json forced =
      json::parse(run_cairn({"sample", pack.name(), "-177.7", "-88.8", "--json", "--level", "0"}).out);
  CHECK(forced.at("level") == 0);
  const json outside = json::parse(run_cairn({"sample", pack.name(), "10", "10", "--json"}).out);
  CHECK(outside.at("height").is_null());
}

TEST_CASE("sample keeps the order of a file's points, their text, and an empty height where there is none") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, kTiles);
  const std::string points = (pack.dir.path() / "points.csv").string();
  std::ofstream(points) << "id,lat,lon\n7,-88.80,-177.6\r\n8,50,10\n\n9,-89,-178.0\n";
  for (const auto& ran :
       {run_cairn({"sample", pack.name(), "--points", points}),
        run_cairn({"sample", pack.name(), "--points", "-"}, "-177.6,-88.80\n10,50\n-178.0,-89\n")}) {
    REQUIRE(ran.exit_code == 0);
    std::istringstream lines(ran.out);
    std::string line;
    std::getline(lines, line);
    const bool with_id = line == "lon,lat,height,level,id";
    CHECK((with_id || line == "lon,lat,height,level"));
    std::getline(lines, line);
    CHECK(line.starts_with("-177.6,-88.80,"));
    CHECK(std::stod(line.substr(14)) == Approx(tilted_metres(-177.6, -88.8)).margin(1e-3));
    CHECK(line.ends_with(with_id ? ",2,7" : ",2"));
    std::getline(lines, line);
    CHECK(line == (with_id ? "10,50,,,8" : "10,50,,"));
    std::getline(lines, line);
    CHECK(line == (with_id ? "-178.0,-89,0.0000,2,9" : "-178.0,-89,0.0000,2"));
    CHECK_FALSE(std::getline(lines, line));
  }
  const json array = json::parse(run_cairn({"sample", pack.name(), "--points", points, "--json"}).out);
  REQUIRE(array.size() == 3);
  CHECK(array.at(1).at("height").is_null());
  CHECK(array.at(2).at("lon") == -178);
  CHECK(json::parse(run_cairn({"sample", pack.name(), "--points", "-", "--json"}).out) == json::array());
}

TEST_CASE("sample names the line of a points file that it cannot read") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, kTiles);
  for (const char* text : {"1,2\n3,x\n", "1,2\n3\n", "lon,lat\nnan,5\n", "1,2\n1e999,5\n"}) {
    const auto ran = run_cairn({"sample", pack.name(), "--points", "-"}, text);
    INFO(text);
    CHECK(ran.exit_code == 3);
    CHECK(is_one_line(ran.err));
    CHECK_THAT(ran.err, Catch::Contains("line 2: expected two numbers lon,lat"));
  }
  CHECK_THAT(run_cairn({"sample", pack.name(), "--points", "-"}, "a,b\n").err,
             Catch::Contains("columns lon,lat"));
  CHECK(run_cairn({"sample", pack.name(), "--points", "/nowhere.csv"}).exit_code == 1);
}

TEST_CASE("sample reports a damaged tile instead of a height") {
  const PackFile pack;
  test::write_test_pack(pack.path, kTilted, {{2, 8, 4}});
  damage(pack.path, kPackStartBytes + 30);
  const auto ran = run_cairn({"sample", pack.name(), "-177.9", "-88.9"});
  CHECK(ran.exit_code == 3);
  CHECK(is_one_line(ran.err));
}

}  // namespace cairn
