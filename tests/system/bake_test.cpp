// Whole bakes, through build(): the error bound on real DEMs, the same bytes whatever the machine does, going
// on after an interruption.

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "builder/bake/journal.h"
#include "builder/heights/measure_pack.h"
#include "builder/raster/raster_source.h"
#include "cairn/build.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

using test::bake;

PackReader open_pack(const fs::path& path) {
  auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  return std::move(*pack);
}

double error_bound_of(const PackReader& pack) {
  return nlohmann::json::parse(pack.metadata_json()).at("error_bound_m").get<double>();
}

// Reads posts of the file itself, every `step`-th, and asks the pack for the height there: nothing of the
// mosaic, the plan or the bake's own measurement is used. Returns the largest difference.
double worst_at_posts(const fs::path& file, const PackReader& pack, std::int64_t step) {
  const auto raster = open_raster(file, {});
  REQUIRE(raster.ok());
  const RasterInfo& info = (*raster)->info();
  PackSampler sampler(pack, 64);
  double worst = 0;
  std::vector<float> row(static_cast<std::size_t>(info.columns));
  for (std::int64_t r = 1; r < info.rows - 1; r += step) {
    REQUIRE((*raster)->read_heights({0, r, info.columns, 1}, row).ok());
    for (std::int64_t c = 1; c < info.columns - 1; c += step) {
      const float post = row[static_cast<std::size_t>(c)];
      if (std::isnan(post)) continue;
      const LonLat place = info.georeference.place_of(static_cast<double>(c), static_cast<double>(r));
      const auto height = sampler.height_at(place);
      REQUIRE(height.ok());
      REQUIRE(height->has_value());
      worst = std::max(worst, std::abs((*height)->metres - static_cast<double>(post)));
    }
  }
  return worst;
}

// Bakes the files and holds the pack against them in three ways that share little.
void bake_and_check(const std::vector<std::string>& names, std::int64_t step = 5) {
  const auto data = test::real_data();
  if (!data) return;
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(*data / name);
  const test::TempDir dir;
  const BuildOptions options = test::bake_options(files, dir.path() / "a.cairn");
  bake(options);
  const auto verified = verify_pack(options.session.target, {2, 10});
  REQUIRE(verified.ok());
  for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
  CHECK(verified->ok());

  const PackReader pack = open_pack(options.session.target);
  const double error_bound_m = error_bound_of(pack);
  const auto measured = measure_pack(pack, options.mosaic, options.heights, options.grid, options.session,
                                     [](const Progress&) { return true; });
  REQUIRE(measured.ok());
  CHECK(measured->max() <= error_bound_m);
  CHECK(measured->count() > 0);
  for (const fs::path& file : files) {
    INFO(file);
    CHECK(worst_at_posts(file, pack, step) <= error_bound_m);
  }
}

}  // namespace

TEST_CASE("every post of a 3-second cell in the mountains is within the error bound") {
  bake_and_check({"srtm3/N44W072.hgt"});
}
TEST_CASE("every post on the equator is within the error bound") {
  bake_and_check({"srtm3/N00E010.hgt"});
}
TEST_CASE("every post of the ocean near the antimeridian is within the error bound") {
  bake_and_check({"srtm3/N00W177.hgt"});
}
TEST_CASE("every post of a coast with land below the sea is within the error bound") {
  bake_and_check({"srtm3/N57E011.hgt"});
}
TEST_CASE("every post of four cells in a row is within the error bound") {
  bake_and_check(
      {"srtm3/N51W001.hgt.zip", "srtm3/N51E000.hgt.zip", "srtm3/N51E001.hgt.zip", "srtm3/N51E002.hgt.zip"},
      9);
}
TEST_CASE("every valid post of cells with voids in the mountains is within the error bound") {
  bake_and_check({"srtm3/N41E001.hgt.zip", "srtm3/N42E001.hgt.zip"}, 9);
}
TEST_CASE("every valid post of a 1-second cell, half of it void, is within the error bound") {
  bake_and_check({"srtm1/N48W125.hgt.zip"}, 17);
}
TEST_CASE("every post inside 1-second cells that disagree on their edges is within the error bound") {
  bake_and_check({"srtm1/S02E034.hgt.zip", "srtm1/S02E035.hgt.zip"}, 17);
}
TEST_CASE("every post of DTED cells in a plus shape is within the error bound") {
  bake_and_check({"dted1/n18_w156_3arc_v2.dt1", "dted1/n19_w155_3arc_v2.dt1", "dted1/n19_w156_3arc_v2.dt1",
                  "dted1/n19_w157_3arc_v2.dt1", "dted1/n20_w156_3arc_v2.dt1"},
                 11);
}
TEST_CASE("every valid post of GeoTIFF cells is within the error bound") {
  bake_and_check({"geotiff/N46E008.tif"});
  bake_and_check({"geotiff/N49W124.tif", "geotiff/N49W123.tif"}, 9);
  bake_and_check({"geotiff/mt_rainier_90m.tif"}, 9);
}
TEST_CASE("every post of a float raster of odd size is within 5 cm") {
  bake_and_check({"geotiff/swellendam_srtm_41_19_4326.tif"});
}
TEST_CASE("every post of a UTM raster is within the error bound") {
  bake_and_check({"utm/bigtujunga_30m_utm11n.tif"}, 7);
}
TEST_CASE("every post of a small UTM raster in floats is within 5 cm") {
  bake_and_check({"utm/st_helens_nad83_5.tif"});
}
TEST_CASE("every post of the whole Earth is within the error bound, poles and antimeridian included") {
  bake_and_check({"global/etopo5_4320x2161.tif"}, 7);
}

TEST_CASE("the same inputs give the same bytes, whatever the threads, the memory and the interruptions") {
  const test::TempDir dir;
  const fs::path first = dir.path() / "first.cairn";
  bake(test::bake_options(
      {test::sample_dem() / "jacksboro_fault.tif", test::sample_dem() / "etopo5_thinned.tif"}, first));
  const auto expected = test::read_bytes(first);
  for (const int threads : {1, 2, 4}) {
    for (const std::size_t mebibytes : {128, 1024}) {
      BuildOptions options = test::bake_options(
          {test::sample_dem() / "jacksboro_fault.tif", test::sample_dem() / "etopo5_thinned.tif"},
          dir.path() / "again.cairn");
      options.session.threads = threads;
      options.session.memory_bytes = mebibytes << 20;
      bake(options);
      INFO(threads << " threads, " << mebibytes << " MiB");
      CHECK(test::read_bytes(options.session.target) == expected);
    }
  }
}

TEST_CASE("a bake cut off after any unit goes on to the same bytes, and a damaged journal costs work only") {
  const test::TempDir dir;
  const std::vector<fs::path> inputs{test::sample_dem() / "jacksboro_fault.tif"};
  BuildOptions options = test::bake_options(inputs, dir.path() / "whole.cairn");
  options.grid.tile_size = 257;
  options.mosaic.level = 5;  // more units than the sample would have
  bake(options);
  const auto expected = test::read_bytes(options.session.target);

  options.session.target = dir.path() / "cut.cairn";
  options.session.resume = true;
  const fs::path journal = Journal::path_for(options.session.target);
  const fs::path part = fs::path(options.session.target).concat(".part");
  for (const std::uint64_t cut_after : {1, 3, 7}) {
    std::uint64_t calls = 0;
    const auto cancelled = build(options, [&](const Progress&) { return ++calls < cut_after; });
    REQUIRE_FALSE(cancelled.ok());
    CHECK(calls == cut_after);
    REQUIRE(fs::exists(journal));
    REQUIRE(fs::exists(part));
    CHECK_FALSE(PackReader::open(part).ok());
    CHECK_FALSE(fs::exists(options.session.target));
    auto bytes = test::read_bytes(journal);
    bytes.resize(bytes.size() - 7);  // the last record is not whole
    test::write_bytes(journal, bytes);
    const auto report = build(options, [](const Progress&) { return true; });
    REQUIRE(report.ok());
    CHECK(report->resumed == (cut_after > 1));
    CHECK(test::read_bytes(options.session.target) == expected);
    CHECK_FALSE(fs::exists(journal));
    fs::remove(options.session.target);
  }
}

TEST_CASE("a bake cancelled from its progress callback keeps its work without being asked to resume") {
  const test::TempDir dir;
  BuildOptions options =
      test::bake_options({test::sample_dem() / "jacksboro_fault.tif"}, dir.path() / "whole.cairn");
  options.grid.tile_size = 257;
  options.mosaic.level = 5;
  bake(options);
  const auto expected = test::read_bytes(options.session.target);

  options.session.target = dir.path() / "cut.cairn";
  std::uint64_t done = 0;
  const auto cancelled = build(options, [&](const Progress& p) {
    done = p.done;
    return false;
  });
  REQUIRE_FALSE(cancelled.ok());
  CHECK(cancelled.error().code == ErrorCode::failed);
  CHECK(remedies_for(cancelled.error(), options) == std::vector{Remedy::resume});
  CHECK_THAT(cancelled.error().message, Catch::Contains("heights after " + std::to_string(done) + " of "));
  CHECK(fs::exists(Journal::path_for(options.session.target)));
  CHECK_FALSE(fs::exists(options.session.target));

  options.session.resume = true;
  const auto report = build(options, [](const Progress&) { return true; });
  REQUIRE(report.ok());
  CHECK(report->resumed);
  CHECK(test::read_bytes(options.session.target) == expected);
  CHECK_FALSE(fs::exists(Journal::path_for(options.session.target)));
}

TEST_CASE("voids are filled without a cliff, or kept as holes, as asked", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  BuildOptions options = test::bake_options({*data / "geotiff/N46E008.tif"}, dir.path() / "a.cairn");
  bake(options);
  const auto raster = open_raster(options.mosaic.inputs.front(), {});
  REQUIRE(raster.ok());
  const RasterInfo& info = (*raster)->info();
  std::vector<float> posts(static_cast<std::size_t>(info.columns * info.rows));
  REQUIRE((*raster)->read_heights({0, 0, info.columns, info.rows}, posts).ok());
  std::vector<LonLat> voids;
  for (std::int64_t i = 0; i < info.columns * info.rows; i += 101) {
    const std::int64_t c = i % info.columns;
    const std::int64_t r = i / info.columns;
    const bool inside = c > 2 && r > 2 && c < info.columns - 3 && r < info.rows - 3;
    bool all_void = inside;
    for (std::int64_t k = 0; inside && k < 25; ++k) {
      all_void = all_void &&
                 std::isnan(posts[static_cast<std::size_t>((r - 2 + k / 5) * info.columns + c - 2 + k % 5)]);
    }
    if (all_void) voids.push_back(info.georeference.place_of(static_cast<double>(c), static_cast<double>(r)));
  }
  REQUIRE(voids.size() > 100);
  {
    const PackReader pack = open_pack(options.session.target);
    PackSampler sampler(pack);
    for (const LonLat& place : voids) {
      const auto height = sampler.height_at(place);
      REQUIRE((height.ok() && height->has_value()));
      CHECK(((*height)->metres > 150 && (*height)->metres < 4700));  // the range of the cell's own posts
    }
  }
  options.heights.voids = VoidMode::keep;
  bake(options);
  const PackReader pack = open_pack(options.session.target);
  PackSampler sampler(pack);
  for (const LonLat& place : voids) {
    const auto height = sampler.height_at(place);
    REQUIRE(height.ok());
    CHECK_FALSE(height->has_value());
  }
  CHECK(verify_pack(options.session.target)->ok());
}

TEST_CASE("open sea stops early: no fine tiles, and its parent's surface is the sea", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  const BuildOptions options = test::bake_options({*data / "srtm3/N00W177.hgt"}, dir.path() / "a.cairn");
  bake(options);
  const PackReader pack = open_pack(options.session.target);
  std::size_t fine = 0;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) fine += pack.entry(i).id.level == 2 ? 1 : 0;
  CHECK(fine > 0);
  CHECK(fine < 16);
}

TEST_CASE("levels coarser than a cell share their edges where the sources end on one", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  BuildOptions options =
      test::bake_options({*data / "dted1/n18_w156_3arc_v2.dt1", *data / "dted1/n19_w155_3arc_v2.dt1",
                          *data / "dted1/n19_w156_3arc_v2.dt1", *data / "dted1/n19_w157_3arc_v2.dt1",
                          *data / "dted1/n20_w156_3arc_v2.dt1"},
                         dir.path() / "a.cairn");
  options.grid.top = kMinLevel;
  for (const int tile_size : {257, 513}) {
    options.grid.tile_size = tile_size;
    bake(options);
    const auto verified = verify_pack(options.session.target, {2, 10});
    REQUIRE(verified.ok());
    for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
    CHECK(verified->ok());
    const PackReader pack = open_pack(options.session.target);
    CHECK(pack.find(Layer::heights, {kMinLevel, 0, 0}).has_value());
    const auto accuracy = nlohmann::json::parse(pack.metadata_json()).at("accuracy");
    CHECK(accuracy.at("posts").get<std::uint64_t>() == 5u * 1201 * 1201 - 4u * 1201);  // shared edges once
  }
}

TEST_CASE("a geoid moves every post by its undulation", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  BuildOptions options = test::bake_options({*data / "srtm3/N44W072.hgt"}, dir.path() / "a.cairn");
  bake(options);
  options.session.target = dir.path() / "b.cairn";
  options.mosaic.geoid = *data / "geoid/us_nga_egm96_15.tif";
  bake(options);
  const PackReader orthometric = open_pack(dir.path() / "a.cairn");
  const PackReader ellipsoidal = open_pack(dir.path() / "b.cairn");
  CHECK(ellipsoidal.header().vertical_datum == VerticalDatum::ellipsoid);
  PackSampler a(orthometric);
  PackSampler b(ellipsoidal);
  // A post of the geoid's own grid: EGM96 at 44.25°N 71.75°W, as the raster has it.
  const auto geoid = open_raster(*options.mosaic.geoid, {});
  const auto post = (*geoid)->info().georeference.post_at({-71.75, 44.25});
  float undulation = 0;
  const PostWindow window{std::llround(post.column), std::llround(post.row), 1, 1};
  REQUIRE((*geoid)->read_heights(window, {&undulation, 1}).ok());
  const double difference = (*b.height_at({-71.75, 44.25}))->metres - (*a.height_at({-71.75, 44.25}))->metres;
  CHECK(difference == Approx(static_cast<double>(undulation)).margin(0.3));
  CHECK(std::abs(undulation) > 10);
}

TEST_CASE("an exceeded error bound fails the bake, names the place and keeps the work for accepting it") {
  const test::TempDir dir;
  BuildOptions options =
      test::bake_options({test::sample_dem() / "jacksboro_fault.tif"}, dir.path() / "a.cairn");
  options.mosaic.resampling = ResampleMethod::bilinear;
  const auto refused = build(options, [](const Progress&) { return true; });
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::failed);
  CHECK_THAT(refused.error().message, Catch::Contains("lon -84") && Catch::Contains("lat 36"));
  CHECK(remedies_for(refused.error(), options) == std::vector{Remedy::accept_error, Remedy::resume});
  CHECK_FALSE(fs::exists(options.session.target));
  options.heights.allow_error = true;
  options.session.resume = true;
  const auto warned = build(options, [](const Progress&) { return true; });
  REQUIRE(warned.ok());
  CHECK(warned->resumed);
  CHECK_FALSE(warned->within_error_bound);
  CHECK_THAT(warned->warning, Catch::Contains("lon -84"));
}

}  // namespace cairn
