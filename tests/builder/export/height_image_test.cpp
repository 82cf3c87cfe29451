#include "builder/export/height_image.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "builder/export/whole_metres.h"
#include "builder/raster/raster_source.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

const TileId kTile{2, 833, 507};
const test::TestSurface kHoles{257, 2, test::hills, [](auto c, auto r) { return (c * c + r * r) % 97 < 30; }};

HeightImage holed_image(double quantum) {
  PackHeader header = test::test_header();
  header.quantum_m = quantum;
  return image_of(kHoles.tile(kTile), kTile, header);
}

/// The file read back as any raster is, compared with the image to within `tolerance` metres.
void check_raster(const std::filesystem::path& path, const HeightImage& image, double tolerance) {
  const auto source = open_raster(path, {});
  INFO((source.ok() ? "" : source.error().message));
  REQUIRE(source.ok());
  const RasterInfo& info = (*source)->info();
  REQUIRE(info.columns == image.size);
  REQUIRE(info.rows == image.size);
  const LonLat first = info.georeference.place_of(0, 0);
  CHECK(first.lon == Approx(image.west).margin(1e-12));
  CHECK(first.lat == Approx(image.north).margin(1e-12));
  CHECK(info.georeference.place_of(image.size - 1, 0).lon == Approx(image.west + 256 * image.spacing));
  std::vector<float> heights(image.metres.size());
  REQUIRE((*source)->read_heights({0, 0, info.columns, info.rows}, heights).ok());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double expected = image.metres[i], found = static_cast<double>(heights[i]);
    const bool same = std::isnan(expected) ? std::isnan(found) : std::abs(expected - found) <= tolerance;
    if (!same) ++wrong;
  }
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("an image has its tile's rows from north to south, its place and its voids") {
  const HeightTile tile = kHoles.tile(kTile);
  const HeightImage image = holed_image(0.25);
  CHECK(image.west == 28.25);
  CHECK(image.north == 37.0);
  CHECK(image.spacing == 0.25 / 256);
  for (const auto& [column, row] : {std::pair(0, 0), {256, 0}, {13, 200}, {256, 256}}) {
    const double metres = image.metres[static_cast<std::size_t>((256 - row) * 257 + column)];
    if (tile.is_void(column, row)) {
      CHECK(std::isnan(metres));
    } else {
      CHECK(metres == tile.at(column, row) * 0.25);
    }
  }
}

TEST_CASE("a tile written as GeoTIFF is read back where it was, exactly, whether whole metres or not") {
  const test::TempDir dir;
  for (const double quantum : {0.25, 1.0}) {
    REQUIRE(write_height_tiff(dir.path() / "t.tif", holed_image(quantum)).ok());
    check_raster(dir.path() / "t.tif", holed_image(quantum), 0);
    CHECK((*open_raster(dir.path() / "t.tif", {}))->info().whole_metres == (quantum == 1.0));
  }
  CHECK_FALSE(std::filesystem::exists(dir.path() / "t.tif.part"));
}

TEST_CASE("a tile written as .hgt is big-endian whole metres from the north-west") {
  const test::TempDir dir;
  const HeightImage image = holed_image(0.25);
  REQUIRE(write_height_hgt(dir.path() / "t.hgt", image).ok());
  const auto bytes = test::read_bytes(dir.path() / "t.hgt");
  REQUIRE(bytes.size() == 2 * 257 * 257);
  for (std::size_t i = 0; i < image.metres.size(); ++i) {
    const auto value = static_cast<std::int16_t>(std::to_integer<int>(bytes[2 * i]) << 8 |
                                                 std::to_integer<int>(bytes[2 * i + 1]));
    const bool same =
        std::isnan(image.metres[i]) ? value == -32768 : std::abs(value - image.metres[i]) <= 0.5;
    if (!same) FAIL("post " << i);
  }
}

TEST_CASE("heights past int16 are kept at its ends, apart from the void") {
  CHECK(whole_metres(1e6) == 32767);
  CHECK(whole_metres(-1e6) == -32767);
  CHECK(whole_metres(-0.5) == 0);
  CHECK(whole_metres(2.5) == 3);
  CHECK(whole_metres(std::nan("")) == -32768);
}

TEST_CASE("a file that cannot be written is an error that names it, in every format") {
  using Writer = Status (*)(const std::filesystem::path&, const HeightImage&);
  const std::pair<Writer, const char*> writers[] = {
      {write_height_tiff, "t.tif"}, {write_height_png, "t.png"}, {write_height_hgt, "t.hgt"}};
  for (const auto& [write, name] : writers) {
    const Status status = write(std::filesystem::path("/nowhere") / name, holed_image(0.25));
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().code == ErrorCode::failed);
    CHECK_THAT(status.error().message, Catch::Contains(name));
    CHECK_THAT(status.error().message, !Catch::Contains("\n"));
  }
}

}  // namespace cairn
