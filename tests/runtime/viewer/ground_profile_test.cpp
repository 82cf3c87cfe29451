#include "runtime/viewer/ground_profile.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include <catch2/catch.hpp>

#include "runtime/viewer/ground_probe.h"
#include "runtime/viewer/settings.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::viewer {
namespace {

std::shared_ptr<const PackReader> hill_pack(const test::TempDir& dir) {
  test::write_test_pack(dir.path() / "a.cairn", {257, 2, test::hills, {}},
                        test::with_ancestors({{2, 832, 508}, {2, 833, 508}}, 0));
  Result<PackReader> opened = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(opened.ok());
  return std::make_shared<const PackReader>(std::move(*opened));
}

}  // namespace

TEST_CASE("a profile has the sampler's heights, and lengths along meridian and equator") {
  const test::TempDir dir;
  const auto pack = hill_pack(dir);
  const GeoBounds b = tile_bounds({2, 832, 508});
  const std::vector<LonLat> line = {
      {b.west + 0.01, b.south + 0.01}, {b.west + 0.4, b.south + 0.2}, {b.west + 1.6, b.south + 0.1}};
  const auto rows = ground_profile(*pack, line, 50);
  REQUIRE(rows.ok());
  REQUIRE(rows->size() == 101);
  CHECK(rows->front().distance_m == 0);
  PackSampler sampler(*pack);
  int without = 0;
  for (const ProfileRow& row : *rows) {
    const auto height = sampler.height_at(row.place);
    REQUIRE(height.ok());
    REQUIRE(height->has_value() == row.height.has_value());
    if (row.height) CHECK(row.height->metres == (*height)->metres);
    without += row.height ? 0 : 1;
  }
  CHECK(without > 10);  // beyond the tiles' end
  const std::string csv = to_csv(*rows);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 102);
  CHECK(csv.find(",,\n") != std::string::npos);
  // WGS84: a degree of the equator, and the quarter of a meridian.
  CHECK(length_m(*pack, {{179.5, 0}, {-179.5, 0}}) == Approx(111319.4908).epsilon(1e-7));
  CHECK(length_m(*pack, {{20, 0}, {20, 90}}) == Approx(10001965.729).epsilon(1e-6));
  CHECK(length_m(*pack, {}) == 0);
}

TEST_CASE("the ground under the cursor is looked up on another thread, the latest place last") {
  const test::TempDir dir;
  const auto pack = hill_pack(dir);
  const GeoBounds b = tile_bounds({2, 832, 508});
  GroundProbe probe(pack);
  CHECK_FALSE(probe.latest());
  const LonLat last{b.west + 0.1, b.south + 0.1};
  for (int i = 0; i < 100; ++i) probe.ask({b.west + 0.001 * i, b.south + 0.05});
  probe.ask(last);
  while (!probe.latest() || probe.latest()->place.lat != last.lat) std::this_thread::yield();
  const auto ground = probe.latest();
  PackSampler sampler(*pack);
  REQUIRE(ground->height);
  CHECK(ground->height->metres == (*sampler.height_at(last))->metres);
  CHECK_THAT(text_of(*ground), Catch::Contains(" m, posts within ") && Catch::Contains("(level 2)"));
  CHECK_THAT(text_of({{5, 6}, {}}), Catch::Contains("5.000000, 6.000000: no height"));
}

TEST_CASE("settings are read as they were kept, and damaged ones change nothing") {
  const test::TempDir dir;
  const auto path = dir.path() / "new" / "view.json";
  Options kept;
  kept.tint = "atlas";
  kept.imagery = 0.25;
  kept.exposure_ev = -1;
  kept.sea_m = 12;
  kept.contours_m = 20;
  kept.slopes = kept.no_shadows = kept.no_fog = true;
  kept.tolerance_px = 2;
  kept.hour = 17.5;
  REQUIRE(write_settings(path, kept).ok());
  Options read;
  REQUIRE(read_settings(path, read).ok());
  CHECK(read.tint == "atlas");
  CHECK(read.imagery == 0.25);
  CHECK(read.exposure_ev == -1);
  CHECK(read.sea_m == 12.0);
  CHECK(read.contours_m == 20);
  CHECK((read.slopes && read.no_shadows && read.no_fog));
  CHECK(read.tolerance_px == 2);
  CHECK(read.hour == 17.5);
  const auto whole = test::read_bytes(path);
  for (std::size_t size = 0; size + 3 < whole.size(); size += 5) {
    test::write_bytes(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    Options other;
    const Status status = read_settings(path, other);
    REQUIRE(!status.ok());
    CHECK(status.error().code == ErrorCode::bad_data);
    CHECK(other.hour == Options().hour);
  }
  const std::string strange = R"({"hour": 99, "imagery": "all", "tolerance": 0, "slopes": 1, "sea": null})";
  const auto bytes = std::as_bytes(std::span(strange));
  test::write_bytes(path, {bytes.begin(), bytes.end()});
  Options other;
  REQUIRE(read_settings(path, other).ok());
  CHECK(other.hour == Options().hour);
  CHECK(other.imagery == 1);
  CHECK(other.tolerance_px == 1);
  CHECK_FALSE(other.slopes);
  CHECK_FALSE(other.sea_m);
  CHECK(read_settings(dir.path() / "no-such-file", other).ok());
}

}  // namespace cairn::viewer
