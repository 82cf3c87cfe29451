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

/// A tile with holes, and what is written of it.
struct Holed {
  explicit Holed(double quantum) {
    header.quantum_m = quantum;
    for (int row = 0; row < 257; ++row)
      REQUIRE(rows(row, std::span(metres).subspan(static_cast<std::size_t>(row) * 257, 257)).ok());
  }
  PackHeader header = test::test_header();
  HeightTile tile = kHoles.tile(kTile);
  std::vector<double> metres = std::vector<double>(257 * 257);

  HeightGrid grid() const { return grid_of(tile, kTile, header); }
  HeightRows rows = [this](int row, std::span<double> out) { return rows_of(tile, header)(row, out); };
};

/// The file read back as any raster is, compared with the image to within `tolerance` metres.
void check_raster(const std::filesystem::path& path, const HeightGrid& grid,
                  const std::vector<double>& metres, double tolerance) {
  const auto source = open_raster(path, {});
  INFO((source.ok() ? "" : source.error().message));
  REQUIRE(source.ok());
  const RasterInfo& info = (*source)->info();
  REQUIRE(info.columns == grid.posts.columns);
  REQUIRE(info.rows == grid.posts.rows);
  const LonLat first = info.georeference.place_of(0, 0);
  CHECK(first.lon == Approx(grid.posts.west).margin(1e-12));
  CHECK(first.lat == Approx(grid.posts.north).margin(1e-12));
  CHECK(info.georeference.place_of(256, 0).lon == Approx(grid.posts.west + 256 * grid.posts.column_degrees));
  std::vector<float> heights(metres.size());
  REQUIRE((*source)->read_heights({0, 0, info.columns, info.rows}, heights).ok());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double expected = metres[i], found = static_cast<double>(heights[i]);
    const bool same = std::isnan(expected) ? std::isnan(found) : std::abs(expected - found) <= tolerance;
    if (!same) ++wrong;
  }
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("an image has its tile's rows from north to south, its place and its voids") {
  const Holed holed(0.25);
  const HeightTile& tile = holed.tile;
  const GeoGrid posts = holed.grid().posts;
  CHECK(posts.west == 28.25);
  CHECK(posts.north == 37.0);
  CHECK(posts.column_degrees == 0.25 / 256);
  CHECK_FALSE(holed.grid().whole_metres);
  CHECK(Holed(1.0).grid().whole_metres);
  for (const auto& [column, row] : {std::pair(0, 0), {256, 0}, {13, 200}, {256, 256}}) {
    const double metres = holed.metres[static_cast<std::size_t>((256 - row) * 257 + column)];
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
    const Holed holed(quantum);
    REQUIRE(write_height_tiff(dir.path() / "t.tif", holed.grid(), holed.rows).ok());
    check_raster(dir.path() / "t.tif", holed.grid(), holed.metres, 0);
    CHECK((*open_raster(dir.path() / "t.tif", {}))->info().whole_metres == (quantum == 1.0));
  }
  CHECK_FALSE(std::filesystem::exists(dir.path() / "t.tif.part"));
}

TEST_CASE("a tile written as .hgt is big-endian whole metres from the north-west") {
  const test::TempDir dir;
  const Holed holed(0.25);
  REQUIRE(write_height_hgt(dir.path() / "t.hgt", holed.grid(), holed.rows).ok());
  const auto bytes = test::read_bytes(dir.path() / "t.hgt");
  REQUIRE(bytes.size() == 2 * 257 * 257);
  for (std::size_t i = 0; i < holed.metres.size(); ++i) {
    const auto value = static_cast<std::int16_t>(std::to_integer<int>(bytes[2 * i]) << 8 |
                                                 std::to_integer<int>(bytes[2 * i + 1]));
    const bool same =
        std::isnan(holed.metres[i]) ? value == -32768 : std::abs(value - holed.metres[i]) <= 0.5;
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
  using Writer = Status (*)(const std::filesystem::path&, const HeightGrid&, const HeightRows&);
  const Holed holed(0.25);
  const std::pair<Writer, const char*> writers[] = {
      {write_height_tiff, "t.tif"}, {write_height_png, "t.png"}, {write_height_hgt, "t.hgt"}};
  for (const auto& [write, name] : writers) {
    const Status status = write(std::filesystem::path("/nowhere") / name, holed.grid(), holed.rows);
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().code == ErrorCode::failed);
    CHECK_THAT(status.error().message, Catch::Contains(name));
    CHECK_THAT(status.error().message, !Catch::Contains("\n"));
  }
}

}  // namespace cairn
