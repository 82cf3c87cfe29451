// Of what heights from several sources are measured from, and which of them do not go together.

#include "builder/mosaic/vertical_datum.h"

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

// A raster pool of one GeoTIFF for each vertical CRS; 0 says none, 4979 is the ellipsoid.
std::unique_ptr<RasterPool> pool_of(const TempDir& folder, const std::vector<int>& references) {
  std::vector<std::filesystem::path> paths;
  for (const int code : references) {
    TiffRecipe recipe;
    if (code == 4979) recipe.keys[2048] = code;
    if (code != 4979 && code != 0) recipe.keys[4096] = code;
    paths.push_back(folder.path() / ("x" + std::to_string(paths.size()) + ".tif"));
    write_tiff(paths.back(), recipe);
  }
  auto pool = RasterPool::open(paths, {}, RasterPool::Content::heights);
  REQUIRE(pool.ok());
  return std::move(*pool);
}

VerticalDatum datum_of(const TempDir& folder, const std::vector<int>& references, bool with_geoid = false) {
  const auto datum = vertical_datum_of(*pool_of(folder, references), {}, with_geoid);
  REQUIRE(datum.ok());
  return datum->datum;
}

}  // namespace

TEST_CASE("the datum is what all sources say") {
  const TempDir folder;
  using enum VerticalDatum;
  CHECK(datum_of(folder, {5773, 5773}) == egm96);
  CHECK(datum_of(folder, {4979}) == ellipsoid);
  CHECK(datum_of(folder, {5773, 0}) == unknown);
  CHECK(datum_of(folder, {0}) == unknown);
  CHECK(datum_of(folder, {3855, 3855}) == unknown);
  CHECK(datum_of(folder, {5773}, true) == ellipsoid);
  CHECK(vertical_datum_of(*pool_of(folder, {3855, 3855}), {}, false)->vertical_crs == "EGM2008 height");
  CHECK(vertical_datum_of(*pool_of(folder, {5728}), {}, false)->vertical_crs == "LN02 height");
  CHECK(vertical_datum_of(*pool_of(folder, {5773, 0}), {}, false)->vertical_crs.empty());
}

TEST_CASE("heights of one datum in metres and in feet go together") {
  const TempDir folder;
  const auto datum = vertical_datum_of(*pool_of(folder, {5703, 6360, 8228}), {}, false);
  REQUIRE(datum.ok());
  CHECK(datum->vertical_crs == "NAVD88 height");
  CHECK(other_datum_of(*datum) == "NAVD88 height");
}

TEST_CASE("a pack's name of a datum has whole characters, and at most 39 bytes") {
  const std::string name = "Altitude au-dessus de la mer \u00e0 Gen\u00e8ve \u00e9t\u00e9";
  const std::string cut = other_datum_of({VerticalDatum::unknown, name});
  CHECK(cut.size() <= 39);
  CHECK(cut.size() >= 38);
  CHECK(name.starts_with(cut));
  CHECK((static_cast<unsigned char>(name[cut.size()]) & 0xC0) != 0x80);
  CHECK(other_datum_of({VerticalDatum::egm96, "EGM96 height"}).empty());
  CHECK(other_datum_of({}).empty());
}

TEST_CASE("sources of different datums are refused unless it is told what they are") {
  const TempDir folder;
  for (const std::vector<int>& mixed :
       {std::vector{4979, 5773}, {5773, 0, 3855}, {5703, 5773}, {5728, 5729}}) {
    const auto pool = pool_of(folder, mixed);
    const auto datum = vertical_datum_of(*pool, {}, false);
    REQUIRE_FALSE(datum.ok());
    CHECK(datum.error().message.find("vertical CRS: expected ") != std::string::npos);
    CHECK(vertical_datum_of(*pool, VerticalDatum::egm96, false)->datum == VerticalDatum::egm96);
  }
}

TEST_CASE("a geoid is not added to ellipsoidal heights") {
  const TempDir folder;
  CHECK_FALSE(vertical_datum_of(*pool_of(folder, {4979}), {}, true).ok());
  CHECK_FALSE(vertical_datum_of(*pool_of(folder, {0}), VerticalDatum::ellipsoid, true).ok());
  CHECK(vertical_datum_of(*pool_of(folder, {4979}), VerticalDatum::egm96, true).ok());
}

}  // namespace cairn::test
