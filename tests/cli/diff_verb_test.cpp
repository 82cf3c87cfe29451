// `cairn diff`: what it finds between packs whose difference is known, and its exit status, which is
// diff(1)'s.

#include <cstring>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_writer.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_cairn;
using Edit = std::function<void(IndexEntry&, HeightTile&)>;

const test::TestSurface kHills{257, 2, test::hills, {}};
const std::vector<TileId> kTiles = test::with_ancestors({{2, 8, 4}, {2, 9, 4}}, 0);
constexpr TileId kEdited{2, 9, 4};

/// Two packs in a folder of their own.
struct TwoPacks {
  test::TempDir dir;
  fs::path a = dir.path() / "a.cairn";
  fs::path b = dir.path() / "b.cairn";

  test::Ran diff(std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"diff", a.string(), b.string()});
    return run_cairn(options);
  }
  json differences() const {
    const auto ran = diff({"--json"});
    INFO(ran.err);
    REQUIRE(ran.exit_code == 1);
    return json::parse(ran.out);
  }
};

/// Changes the tile kEdited, and makes its entry true again.
Edit edit_of(const std::function<void(HeightTile&)>& change) {
  return [change](IndexEntry& entry, HeightTile& tile) {
    if (entry.id != kEdited) return;
    change(tile);
    entry = test::describe(entry.id, tile);
  };
}

std::size_t at(int column, int row) {
  return static_cast<std::size_t>(row) * 257 + static_cast<std::size_t>(column);
}

/// A pack with one constant tile of imagery.
void write_coloured_pack(const fs::path& path, std::array<std::uint8_t, 4> rgba) {
  auto writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  IndexEntry entry;
  entry.layer = Layer::imagery;
  entry.flags = kConstant;
  entry.id = {0, 2, 1};
  std::memcpy(&entry.min_quanta, rgba.data(), 4);
  entry.max_quanta = entry.min_quanta;
  REQUIRE(writer->add(entry, {}).ok());
  REQUIRE(writer->finish("{}").ok());
}

}  // namespace

TEST_CASE("diff of packs of equal content prints nothing and exits 0") {
  const TwoPacks packs;
  test::write_test_pack(packs.a, kHills, kTiles);
  test::write_test_pack(packs.b, kHills, kTiles);
  const auto ran = packs.diff();
  CHECK(ran.exit_code == 0);
  CHECK(ran.out.empty());
  const auto as_json = packs.diff({"--json"});
  CHECK(as_json.exit_code == 0);
  const json report = json::parse(as_json.out);
  CHECK(report.at("equal") == true);
  CHECK(report.at("tiles").empty());
  CHECK(report.at("layers").at(0).at("equal") == kTiles.size());
}

TEST_CASE("diff names the tile, the place and the metres of one sample that differs") {
  const TwoPacks packs;
  test::write_test_pack(packs.a, kHills, kTiles);
  test::write_test_pack(packs.b, kHills, kTiles, edit_of([](HeightTile& t) { t.samples[at(64, 128)] += 3; }));
  const json report = packs.differences();
  REQUIRE(report.at("tiles").size() == 1);
  const json& tile = report.at("tiles").at(0);
  CHECK(tile.at("tile") == "2/9/4");
  CHECK(tile.at("in") == "both");
  const json& heights = tile.at("heights");
  CHECK(heights.at("samples") == 1);
  CHECK(heights.at("max_m") == 0.75);
  CHECK(heights.at("rms_m").get<double>() == Approx(0.75 / 257));
  CHECK(heights.at("worst").at("lon") == -180 + (9 + 0.25) / 4);
  CHECK(heights.at("worst").at("lat") == -90 + (4 + 0.5) / 4);
  CHECK(heights.at("worst").at("b_m").get<double>() - heights.at("worst").at("a_m").get<double>() == 0.75);
  CHECK(report.at("layers").at(0).at("differing") == 1);
  CHECK(report.at("max_m") == 0.75);
  const auto text = packs.diff();
  CHECK(text.exit_code == 1);
  CHECK_THAT(text.out, Catch::Contains("heights 2/9/4: 1 samples differ, max 0.7500 m") &&
                           Catch::Contains("largest difference 0.7500 m, in 2/9/4"));
}

TEST_CASE("diff counts the samples that are void in one pack only") {
  const TwoPacks packs;
  const auto with_voids = [](int last) {
    return edit_of([last](HeightTile& t) {
      t.voids.assign(t.samples.size(), 0);
      for (int column = 0; column <= last; ++column) t.voids[at(column, 3)] = 1;
    });
  };
  test::write_test_pack(packs.a, kHills, kTiles, with_voids(5));
  test::write_test_pack(packs.b, kHills, kTiles, with_voids(1));
  const json report = packs.differences();
  REQUIRE(report.at("tiles").size() == 1);
  CHECK(report.at("tiles").at(0).at("heights").at("only_in_b") == 4);
  CHECK(report.at("tiles").at(0).at("heights").at("only_in_a") == 0);
  CHECK(report.at("tiles").at(0).at("heights").at("samples") == 0);
  CHECK_THAT(packs.diff().out, Catch::Contains("4 samples have a height in B only"));
}

TEST_CASE("diff compares a tile that one pack lacks with what the other draws there") {
  TwoPacks packs;
  test::write_test_pack(packs.a, kHills, kTiles);
  test::write_test_pack(packs.b, kHills, test::with_ancestors({{2, 8, 4}}, 0));
  const json report = packs.differences();
  REQUIRE(report.at("tiles").size() == 1);
  CHECK(report.at("tiles").at(0).at("in") == "a");
  CHECK(report.at("layers").at(0).at("only_in_a") == 1);
  const auto reader = PackReader::open(packs.b);
  REQUIRE(reader.ok());
  PackSampler sampler(*reader);
  const HeightTile tile = kHills.tile(kEdited);
  double worst = 0;
  for (int row = 0; row < 257; ++row) {
    for (int column = 0; column < 257; ++column) {
      const auto drawn = sampler.height_at({-180 + (9 + column / 256.0) / 4, -90 + (4 + row / 256.0) / 4});
      REQUIRE((drawn.ok() && *drawn));
      worst = std::max(worst, std::abs((*drawn)->metres - tile.at(column, row) * 0.25));
    }
  }
  CHECK(worst > 0);
  CHECK(report.at("tiles").at(0).at("heights").at("max_m").get<double>() == Approx(worst).epsilon(1e-12));

  std::swap(packs.a, packs.b);
  CHECK(packs.differences().at("tiles").at(0).at("in") == "b");
}

TEST_CASE("diff compares heights in metres where the quantum differs, and texels by colour") {
  const TwoPacks packs;
  const auto write = [](const fs::path& path, double quantum, std::int32_t quanta) {
    PackHeader header = test::test_header();
    header.quantum_m = quantum;
    auto writer = PackWriter::create(path, header);
    REQUIRE(writer.ok());
    IndexEntry entry;
    entry.flags = kConstant;
    entry.id = {0, 2, 1};
    entry.min_quanta = entry.max_quanta = quanta;
    REQUIRE(writer->add(entry, {}).ok());
    REQUIRE(writer->finish("{}").ok());
  };
  write(packs.a, 0.25, 40);
  write(packs.b, 0.5, 20);
  json report = packs.differences();
  CHECK(report.at("header") == json::parse(R"([{"key": "quantum_m", "a": 0.25, "b": 0.5}])"));
  CHECK(report.at("tiles").empty());
  fs::remove(packs.b);
  write(packs.b, 0.5, 40);
  report = packs.differences();
  REQUIRE(report.at("tiles").size() == 1);
  CHECK(report.at("tiles").at(0).at("heights").at("max_m") == 10);

  const TwoPacks coloured;
  write_coloured_pack(coloured.a, {10, 20, 30, 255});
  write_coloured_pack(coloured.b, {10, 27, 28, 255});
  report = coloured.differences();
  REQUIRE(report.at("tiles").size() == 1);
  CHECK(report.at("tiles").at(0).at("texels") == json{{"max", 7}, {"differing", 256 * 256}});
}

TEST_CASE("diff says where metadata differ, and where tiles cannot be compared") {
  const TwoPacks packs;
  const auto write = [](const fs::path& path, int tile_size, const std::string& metadata) {
    auto writer = PackWriter::create(path, test::test_header(tile_size));
    REQUIRE(writer.ok());
    REQUIRE(writer->finish(metadata).ok());
  };
  write(packs.a, 257, R"({"options": {"level": 2, "void": "fill"}, "cairn": "x"})");
  write(packs.b, 257, R"({"cairn": "x", "options": {"level": 3, "datum": "egm96", "void": "fill"}})");
  CHECK(packs.differences().at("metadata") == json::parse(R"([{"key": "/options/level", "a": 2, "b": 3},
                                                              {"key": "/options/datum", "a": null, "b": "egm96"}])"));
  fs::remove(packs.b);
  write(packs.b, 513, R"({"options": {"level": 2, "void": "fill"}, "cairn": "x"})");
  CHECK(packs.differences().at("tiles_compared") == false);
  CHECK_THAT(packs.diff().out, Catch::Contains("tiles are not compared"));
}

TEST_CASE("diff fails with 2 or 3, one line and no output, where it cannot compare") {
  const TwoPacks packs;
  test::write_test_pack(packs.a, kHills, kTiles);
  CHECK(packs.diff().exit_code == 2);
  CHECK(test::is_one_line(packs.diff().err));
  std::ofstream(packs.b) << std::string(5000, 'x');
  CHECK(packs.diff().exit_code == 3);
  CHECK(packs.diff().out.empty());
  CHECK(run_cairn({"diff", packs.a.string()}).exit_code == 2);
  test::write_test_pack(packs.b, kHills, kTiles, edit_of([](HeightTile& t) { t.samples[5] += 1; }));
  auto bytes = test::read_bytes(packs.b);
  const auto reader = PackReader::open(packs.b);
  REQUIRE(reader.ok());
  bytes.at(reader->find(Layer::heights, kEdited)->offset + 9) ^= std::byte{1};
  test::write_bytes(packs.b, bytes);
  const auto damaged = packs.diff();
  CHECK(damaged.exit_code == 3);
  CHECK_THAT(damaged.err, Catch::Contains("2/9/4"));
}

}  // namespace cairn
