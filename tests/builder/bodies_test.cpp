// Sources of other bodies: at every post of the files, at its place by a formula, the pack has the file's
// height. The oracle for latitudes is tan φ = (a/b)² tan ψ (Snyder 1987, eq. 3-28), that for the
// equirectangular projection of a sphere is φ = y/R, λ = x/R.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "builder/raster/body_placement.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr double kErrorBound = 0.05;
constexpr double kDegree = M_PI / 180;
const Ellipsoid kMars{3396190, 3376200};
const Ellipsoid kMarsSphere{3396190, 3396190};

double graphic(double centric_deg, const Ellipsoid& e) {
  return std::atan(std::tan(centric_deg * kDegree) * std::pow(e.semi_major_m / e.semi_minor_m, 2)) / kDegree;
}

double height_of(int column, int row) {
  return 900 + 300 * std::sin(column / 7.0) * std::cos(row / 5.0) + (column * 31 + row * 17) % 13;
}

constexpr int kColumns = 48, kRows = 40;

/// Degrees on an ellipsoid that is spelt out, the first post at (west, north).
TiffRecipe degrees_on(const Ellipsoid& e, const std::string& name, double west = 10, double north = 45,
                      double step = 0.01) {
  TiffRecipe recipe;
  recipe.columns = kColumns;
  recipe.rows = kRows;
  recipe.type = SampleType::float32;
  recipe.keys = {{1024, 2}, {1025, 2}, {2048, 32767}, {2050, 32767}, {2054, 9102}, {2056, 32767}};
  recipe.double_keys = {{2057, e.semi_major_m}, {2058, e.semi_minor_m}};
  recipe.citation = name;
  recipe.pixel_scale = {step, step, 0};
  recipe.tiepoint = {0, 0, 0, west, north, 0};
  recipe.sample = [](int, std::int64_t c, std::int64_t r) {
    return height_of(static_cast<int>(c), static_cast<int>(r));
  };
  return recipe;
}

using PlaceOf = std::function<LonLat(int column, int row)>;

double worst_error(const fs::path& path, const PlaceOf& place_of) {
  const auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  PackSampler sampler(*pack, 64);
  double worst = 0;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const auto found = sampler.height_at(place_of(c, r));
      REQUIRE(found.ok());
      REQUIRE(found->has_value());
      worst = std::max(worst, std::abs((*found)->metres - height_of(c, r)));
    }
  }
  return worst;
}

Body body_in(const fs::path& path) {
  const auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  return pack->header().body;
}

BuildOptions options_for(const std::vector<fs::path>& dems, const fs::path& target,
                         const SourceOverrides& said = {}) {
  BuildOptions options = bake_options(dems, target);
  options.grid.tile_size = 257;
  if (said != SourceOverrides{}) options.mosaic.source_rules = {{"*", said}};
  return options;
}

std::string failure_of(const BuildOptions& options) {
  const auto report = build(options, [](const Progress&) { return true; });
  return report ? "" : report.error().message;
}

struct Baked {
  Body body;
  double worst_m = 0;
};

Baked bake_one(const TiffRecipe& recipe, const SourceOverrides& said, const PlaceOf& place_of) {
  const TempDir folder;
  write_tiff(folder.path() / "a.tif", recipe);
  const BuildOptions options = options_for({folder.path() / "a.tif"}, folder.path() / "a.cairn", said);
  bake(options);
  return {body_in(options.session.target), worst_error(options.session.target, place_of)};
}

PlaceOf centric_posts(double west, double north, double step, const Ellipsoid& e) {
  return [=](int c, int r) { return LonLat{west + c * step, graphic(north - r * step, e)}; };
}
PlaceOf graphic_posts(double west, double north, double step) {
  return [=](int c, int r) { return LonLat{west + c * step, north - r * step}; };
}

}  // namespace

TEST_CASE("planetocentric latitudes of Mars become planetographic ones at every post") {
  for (const double north : {45.0, -20.0, 89.5}) {
    const Baked baked = bake_one(degrees_on(kMars, "Mars (2015) / Ocentric", 10, north), {},
                                 centric_posts(10, north, 0.01, kMars));
    CHECK(baked.body == Body{"Mars", kMars});
    CHECK(baked.worst_m <= kErrorBound);
  }
  // Read as planetographic, a post would lie this far from where it is.
  CHECK((graphic(45, kMars) - 45) * kDegree * kMars.semi_major_m == Approx(20e3).epsilon(0.01));
}

TEST_CASE("planetographic latitudes are the pack's own, and a user's word counts more than a name") {
  const Baked named =
      bake_one(degrees_on(kMars, "Mars 2000 planetographic"), {}, graphic_posts(10, 45, 0.01));
  CHECK(named.body == Body{"Mars", kMars});
  CHECK(named.worst_m <= kErrorBound);
  SourceOverrides graphic_told, centric_told;
  graphic_told.latitude = LatitudeKind::planetographic;
  centric_told.latitude = LatitudeKind::planetocentric;
  const TiffRecipe unnamed = degrees_on(kMars, "GCS_Mars_2000"),
                   ocentric = degrees_on(kMars, "Mars / Ocentric");
  CHECK(bake_one(unnamed, graphic_told, graphic_posts(10, 45, 0.01)).worst_m <= kErrorBound);
  CHECK(bake_one(unnamed, centric_told, centric_posts(10, 45, 0.01, kMars)).worst_m <= kErrorBound);
  CHECK(bake_one(ocentric, graphic_told, graphic_posts(10, 45, 0.01)).worst_m <= kErrorBound);
}

TEST_CASE("latitudes of either kind on an ellipsoid are asked for, on a sphere they are one") {
  const TempDir folder;
  write_tiff(folder.path() / "a.tif", degrees_on(kMars, "GCS_Mars_2000"));
  const BuildOptions options = options_for({folder.path() / "a.tif"}, folder.path() / "a.cairn");
  const auto refused = build(options, [](const Progress&) { return true; });
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().message.find("latitude: expected planetographic or planetocentric") !=
        std::string::npos);
  CHECK(remedies_for(refused.error(), options) == std::vector{Remedy::tell_latitude});
  const Baked sphere =
      bake_one(degrees_on(kMarsSphere, "GCS_Mars_2000_Sphere"), {}, graphic_posts(10, 45, 0.01));
  CHECK(sphere.body == Body{"Mars", kMarsSphere});
  CHECK(sphere.worst_m <= kErrorBound);
}

TEST_CASE("degrees of a sphere are planetocentric on an ellipsoid that the user names") {
  SourceOverrides said;
  said.body = "Mars,3396190,3376200";
  const Baked baked = bake_one(degrees_on(kMarsSphere, "sphere"), said, centric_posts(10, 45, 0.01, kMars));
  CHECK(baked.body == Body{"Mars", kMars});
  CHECK(baked.worst_m <= kErrorBound);
}

TEST_CASE("EPSG:4326 carries the degrees of a body that the user names") {
  TiffRecipe recipe = degrees_on({}, "");
  recipe.keys = {{1024, 2}, {1025, 2}, {2048, 4326}};
  recipe.double_keys.clear();
  SourceOverrides said;
  said.body = "moon";
  const Baked moon = bake_one(recipe, said, graphic_posts(10, 45, 0.01));
  CHECK(moon.body == *known_body("Moon"));
  CHECK(moon.worst_m <= kErrorBound);
  said.body = "Mars";
  said.latitude = LatitudeKind::planetocentric;
  const Baked mars = bake_one(recipe, said, centric_posts(10, 45, 0.01, kMars));
  CHECK(mars.body == Body{"Mars", kMars});
  CHECK(mars.worst_m <= kErrorBound);
}

TEST_CASE("west-positive longitudes are turned, and those from 0 to 360 are taken") {
  SourceOverrides west;
  west.longitude = LongitudeSense::west;
  const TiffRecipe moon = degrees_on({1737400, 1737400}, "Moon", 200);
  CHECK(bake_one(moon, west, [](int c, int r) {
          return LonLat{std::remainder(-(200 + c * 0.01), 360), 45 - r * 0.01};
        }).worst_m <= kErrorBound);
  CHECK(bake_one(moon, {}, graphic_posts(200 - 360, 45, 0.01)).worst_m <= kErrorBound);
}

TEST_CASE("an equirectangular map of a sphere lies where its formula puts it") {
  TiffRecipe recipe = degrees_on({1737400, 1737400}, "SimpleCylindrical Moon");
  recipe.keys = {{1024, 1},     {1025, 2},     {2048, 32767}, {2050, 32767}, {2054, 9102},
                 {2056, 32767}, {3072, 32767}, {3074, 32767}, {3075, 17},    {3076, 9001}};
  for (const int id : {3078, 3080, 3081, 3082, 3083, 3088, 3089}) recipe.double_keys[id] = 0;
  recipe.pixel_scale = {200, 200, 0};
  recipe.tiepoint = {0, 0, 0, 100000, -500000, 0};
  const Baked baked = bake_one(recipe, {}, [](int c, int r) {
    return LonLat{(100000 + 200.0 * c) / 1737400 / kDegree, (-500000 - 200.0 * r) / 1737400 / kDegree};
  });
  CHECK(baked.body == *known_body("Moon"));
  CHECK(baked.worst_m <= kErrorBound);
}

TEST_CASE("a PDS3 label's offset that is the sphere's radius gives heights above the sphere") {
  const TempDir folder;
  std::string samples, label;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const auto stored = static_cast<std::uint16_t>(std::lround(2 * height_of(c, r)));
      samples += {static_cast<char>(stored & 255), static_cast<char>(stored >> 8)};
    }
  }
  // Four posts a degree, the first at 20.125°E, 15.875°N.
  for (const char* line : {"PDS_VERSION_ID = PDS3",
                           "RECORD_TYPE = FIXED_LENGTH",
                           "RECORD_BYTES = 96",
                           "FILE_RECORDS = 40",
                           "^IMAGE = \"a.img\"",
                           "OBJECT = IMAGE",
                           "LINES = 40",
                           "LINE_SAMPLES = 48",
                           "SAMPLE_TYPE = LSB_INTEGER",
                           "SAMPLE_BITS = 16",
                           "SCALING_FACTOR = 0.5",
                           "OFFSET = 1737400.",
                           "END_OBJECT = IMAGE",
                           "OBJECT = IMAGE_MAP_PROJECTION",
                           "MAP_PROJECTION_TYPE = \"SIMPLE CYLINDRICAL\"",
                           "A_AXIS_RADIUS = 1737.4 <km>",
                           "B_AXIS_RADIUS = 1737.4 <km>",
                           "C_AXIS_RADIUS = 1737.4 <km>",
                           "TARGET_NAME = MOON",
                           "POSITIVE_LONGITUDE_DIRECTION = \"EAST\"",
                           "CENTER_LATITUDE = 0.0 <deg>",
                           "CENTER_LONGITUDE = 0.0 <deg>",
                           "LINE_PROJECTION_OFFSET = 63.5",
                           "SAMPLE_PROJECTION_OFFSET = -80.5",
                           "MAP_RESOLUTION = 4.0 <pix/deg>",
                           "MAP_SCALE = 7.580838 <km/pix>",
                           "END_OBJECT = IMAGE_MAP_PROJECTION",
                           "END"})
    label += std::string(line) + "\r\n";
  write_text(folder.path() / "a.img", samples);
  write_text(folder.path() / "a.lbl", label);
  const BuildOptions options = options_for({folder.path() / "a.lbl"}, folder.path() / "a.cairn");
  bake(options);
  CHECK(body_in(options.session.target) == *known_body("Moon"));
  const auto pack = PackReader::open(options.session.target);
  REQUIRE(pack.ok());
  PackSampler sampler(*pack, 64);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const auto found = sampler.height_at({20.125 + c / 4.0, 15.875 - r / 4.0});
      REQUIRE(found.ok());
      REQUIRE(found->has_value());
      // Samples are half metres, and the label's scale has 7 digits: 0.02 m of place.
      REQUIRE(std::abs((*found)->metres - std::round(2 * height_of(c, r)) / 2) <= kErrorBound);
    }
  }
}

TEST_CASE("sources of different bodies or ellipsoids make no pack") {
  const TempDir folder;
  const auto write = [&](const char* name, const TiffRecipe& recipe) {
    write_tiff(folder.path() / name, recipe);
    return folder.path() / name;
  };
  TiffRecipe of_earth;
  of_earth.columns = kColumns;
  of_earth.rows = kRows;
  const fs::path earth = write("earth.tif", of_earth);
  const fs::path moon = write("moon.tif", degrees_on({1737400, 1737400}, "Moon"));
  const fs::path mars = write("mars.tif", degrees_on(kMars, "Mars ographic", 20));
  const fs::path sphere = write("sphere.tif", degrees_on(kMarsSphere, "Mars sphere", 30));
  const fs::path target = folder.path() / "a.cairn";
  const auto says = [&](const std::vector<fs::path>& dems, const char* words,
                        const SourceOverrides& said = {}) {
    const BuildOptions options = options_for(dems, target, said);
    const std::string message = failure_of(options);
    INFO(message);
    CHECK(message.find(words) != std::string::npos);
    CHECK_FALSE(fs::exists(target));
  };
  says({moon, earth}, "body: expected Moon");
  says({mars, moon}, "found Moon");
  says({mars, sphere}, "body: expected Mars (3396190 m, 3376200 m)");
  SourceOverrides to_moon;
  to_moon.body = "Moon";
  says({mars}, "expected degrees or a CRS of Moon", to_moon);
  BuildOptions with_egm = options_for({moon}, target);
  with_egm.mosaic.datum = VerticalDatum::egm96;
  CHECK(failure_of(with_egm).find("vertical datum: expected one of Moon") != std::string::npos);
  SourceOverrides to_mars;
  to_mars.body = "Mars,3396190,3376200";
  CHECK(failure_of(options_for({mars, sphere}, target, to_mars)).empty());
}

TEST_CASE("a body is told by name, with semi-axes or by them alone") {
  CHECK(parse_body("Mars")->name == "Mars");
  CHECK_FALSE(parse_body("Mars")->shape);
  CHECK(parse_body("3396190,3376200")->name == "Mars");
  CHECK(parse_body("Vesta,285000,229000")->shape == Ellipsoid{285000, 229000});
  CHECK(parse_body("mars,3396190,3396190")->name == "Mars");
  for (const char* wrong : {"", "Vesta", "1,2", "Mars,1", "Mars,2,1,0", "a,b", "Mars,nan,1", ",2,1", "-1,-2",
                            "Vesta,1e999,1", "Mars,2,0"}) {
    CAPTURE(wrong);
    CHECK_FALSE(parse_body(wrong).ok());
  }
}

}  // namespace cairn::test
