// Whole bakes of images of every kind, through build(): the right picture, or one line that says what is
// wrong.
#include <cmath>
#include <cstdlib>

#include <OpenImageIO/imageio.h>
#include <catch2/catch.hpp>

#include "builder/export/texture_file.h"
#include "cairn/build.h"
#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"
#include "tests/support/texture_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using test::TempDir;
using test::TiffRecipe;
using test::write_tiff;

constexpr int kSide = 96;
constexpr double kPixel = 0.001;  // degrees; images lie east of 10 and south of 50

Result<BuildReport> bake(const std::vector<fs::path>& images, const fs::path& target,
                         std::optional<GeoBounds> bounds = std::nullopt) {
  BuildOptions options;
  options.imagery.inputs = images;
  options.imagery.bounds = bounds;
  options.imagery.format = TextureFormat::bc7;
  options.session.target = target;
  options.grid.tile_size = 257;
  options.session.threads = 2;
  options.session.force = true;
  return build(options, [](const Progress&) { return true; });
}

// Bands of a picture of four quarters: red, green, blue and grey.
double quarters(int band, std::int64_t c, std::int64_t r) {
  const int quarter = (c >= kSide / 2 ? 1 : 0) + (r >= kSide / 2 ? 2 : 0);
  if (band > 2) return 90;
  if (quarter == 3) return 120;
  return quarter == band ? 200 : 20;
}

TiffRecipe picture() {
  TiffRecipe recipe;
  recipe.columns = recipe.rows = kSide;
  recipe.bands = 3;
  recipe.type = SampleType::uint8;
  recipe.photometric = 2;
  recipe.pixel_scale = {kPixel, kPixel, 0};
  recipe.sample = quarters;
  return recipe;
}

LonLat middle_of(int quarter) {
  const double side = kSide * kPixel;
  return {10 + side * (quarter % 2 == 0 ? 0.25 : 0.75), 50 - side * (quarter < 2 ? 0.25 : 0.75)};
}

void expect_quarters(const fs::path& pack_path, const std::array<std::array<int, 3>, 4>& expected,
                     int tolerance) {
  test::TexturePack pack(pack_path);
  for (int q = 0; q < 4; ++q) {
    INFO("quarter " << q);
    const auto colour = pack.colour(middle_of(q));
    REQUIRE(colour.has_value());
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(std::abs((*colour)[k] - expected[static_cast<std::size_t>(q)][k]) <= tolerance);
  }
}

constexpr std::array<std::array<int, 3>, 4> kQuarters = {
    {{200, 20, 20}, {20, 200, 20}, {20, 20, 200}, {120, 120, 120}}};

void expect_refusal(const std::vector<fs::path>& images, const fs::path& target, const std::string& words) {
  const auto report = bake(images, target);
  REQUIRE_FALSE(report.ok());
  INFO(report.error().message);
  CHECK(report.error().code == ErrorCode::bad_data);
  CHECK(report.error().message.find(images.back().filename().string()) != std::string::npos);
  CHECK(report.error().message.find(words) != std::string::npos);
  CHECK(report.error().message.find('\n') == std::string::npos);
  for (const char* left : {"", ".part", ".journal"}) CHECK_FALSE(fs::exists(target.string() + left));
}

}  // namespace

TEST_CASE("images of every layout, depth and packing are baked to the same picture") {
  const TempDir dir;
  const fs::path tiff = dir.path() / "x.tif", target = dir.path() / "a.cairn";
  TiffRecipe recipe = picture();
  int tolerance = 2;
  SECTION("planar") {
    recipe.planar = true;
  }
  SECTION("planar tiles, deflated") {
    recipe.planar = true, recipe.tile = 32, recipe.compression = 8;
  }
  SECTION("four bands, the fourth near infrared") {
    recipe.bands = 4, recipe.extra_samples = {0};
  }
  SECTION("four bands, the fourth marked as alpha, which GDAL's own note denies") {
    recipe.bands = 4, recipe.extra_samples = {2};
    recipe.gdal_metadata =
        "<GDALMetadata><Item name=\"COLORINTERP\" sample=\"3\" "
        "role=\"colorinterp\">Undefined</Item></GDALMetadata>";
  }
  SECTION("16 bits") {
    recipe.type = SampleType::uint16;
    recipe.sample = [](int band, std::int64_t c, std::int64_t r) { return 257 * quarters(band, c, r); };
  }
  SECTION("JPEG in TIFF") {
    recipe.tile = 32, recipe.compression = 7, recipe.photometric = 6;
    tolerance = 10;
  }
  SECTION("big-endian BigTIFF") {
    recipe.big_endian = recipe.big_tiff = true;
  }
  SECTION("a nodata value that no pixel has") {
    recipe.nodata = "7";
  }
  write_tiff(tiff, recipe);
  const auto report = bake({tiff}, target);
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
  expect_quarters(target, kQuarters, tolerance);
}

TEST_CASE("one bit, palettes and two bands are baked as what they mean") {
  const TempDir dir;
  const fs::path tiff = dir.path() / "x.tif", target = dir.path() / "a.cairn";
  TiffRecipe recipe = picture();
  recipe.bands = 1;
  recipe.sample = [](int, std::int64_t c, std::int64_t) { return c >= kSide / 2 ? 1.0 : 0.0; };
  std::array<int, 3> left{0, 0, 0}, right{255, 255, 255};
  SECTION("one bit") {
    recipe.bits = 1, recipe.photometric = 1;
  }
  SECTION("one bit, white is zero") {
    recipe.bits = 1, recipe.photometric = 0;
    std::swap(left, right);
  }
  SECTION("a palette") {
    recipe.bits = 8, recipe.photometric = 3;
    left = {0, 255, 0}, right = {1, 254, 1};  // write_tiff()'s palette: i, 255 - i, i
  }
  SECTION("two bands are grey and one more") {
    recipe.bands = 2, recipe.photometric = 1, recipe.extra_samples = {0};
    recipe.sample = [](int band, std::int64_t c, std::int64_t) {
      return band == 1 ? 0.0 : c >= kSide / 2 ? 180.0 : 60.0;
    };
    left = {60, 60, 60}, right = {180, 180, 180};
  }
  write_tiff(tiff, recipe);
  const auto report = bake({tiff}, target);
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
  expect_quarters(target, {left, right, left, right}, 2);
}

TEST_CASE("images that hold no colours, or fewer than they claim, are refused in one line") {
  const TempDir dir;
  const fs::path tiff = dir.path() / "x.tif", target = dir.path() / "a.cairn";
  TiffRecipe recipe = picture();
  SECTION("RGB of two bands") {
    recipe.bands = 2;
    write_tiff(tiff, recipe);
    expect_refusal({tiff}, target, "three bands");
  }
  SECTION("CMYK") {
    recipe.bands = 4, recipe.photometric = 5;
    write_tiff(tiff, recipe);
    expect_refusal({tiff}, target, "CMYK");
  }
  SECTION("heights") {
    recipe.bands = 1, recipe.photometric = 1, recipe.type = SampleType::float32;
    write_tiff(tiff, recipe);
    expect_refusal({tiff}, target, "float32");
  }
  SECTION("strips that end too soon, plain and packed") {
    recipe.compression = GENERATE(1, 8);
    write_tiff(tiff, recipe);
    auto bytes = test::read_bytes(tiff);
    bytes.resize(bytes.size() / 2);
    test::write_bytes(tiff, bytes);
    expect_refusal({tiff}, target, "");
  }
  SECTION("an image larger than its file") {
    write_tiff(tiff, recipe);
    auto bytes = test::read_bytes(tiff);
    // ImageLength's entry: tag 257; its value lies 8 bytes on, LONG or SHORT.
    for (std::size_t i = 0; i + 12 < bytes.size(); ++i) {
      if (bytes[i] != std::byte{1} || bytes[i + 1] != std::byte{1} || bytes[i + 3] != std::byte{0} ||
          bytes[i + 4] != std::byte{1} || bytes[i + 8] != std::byte{kSide})
        continue;
      bytes[i + 9] = std::byte{0x40};
    }
    test::write_bytes(tiff, bytes);
    expect_refusal({tiff}, target, "");
  }
  SECTION("a corrupt JPEG strip") {
    recipe.compression = 7, recipe.photometric = 6, recipe.rows_per_strip = 16;
    recipe.sample = [](int band, std::int64_t c, std::int64_t r) {
      return static_cast<double>((c * 37 + r * 91 + band * 50) % 256);
    };
    write_tiff(tiff, recipe);
    auto bytes = test::read_bytes(tiff);
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 3),
              bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), std::byte{0xFF});
    test::write_bytes(tiff, bytes);
    expect_refusal({tiff}, target, "");
  }
}

// NAIP's fourth band is near infrared; its TIFF tag says alpha, GDAL's note in it says otherwise.
TEST_CASE("an image in UTM and its copy warped to lat/long make the same texels", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const TempDir dir;
  const fs::path utm = *data / "imagery/m_4709963_se_14_1_20090818.tif", geographic = dir.path() / "ll.tif";
  if (!test::run_gdal("gdalwarp -q -t_srs EPSG:4326 -r cubic -tr 0.00003 0.00003 " + utm.string() + " " +
                      geographic.string()))
    return;
  REQUIRE(bake({utm}, dir.path() / "utm.cairn").ok());
  REQUIRE(bake({geographic}, dir.path() / "ll.cairn").ok());
  test::TexturePack a(dir.path() / "utm.cairn"), b(dir.path() / "ll.cairn");
  // The copy has finer pixels, so its pack may go a level deeper: compared at the coarser one's.
  const double step = tile_width_degrees(a.finest()) / a.size();
  double sum = 0;
  int compared = 0, opaque = 0, total = 0;
  for (double lat = 47.006; lat < 47.035; lat += 9.37 * step) {
    for (double lon = -99.183; lon < -99.126; lon += 7.77 * step) {
      ++total;
      const auto one = a.colour({lon, lat});
      opaque += one.has_value();
      const auto other = b.colour({lon, lat});
      if (!one || !other) continue;
      for (std::size_t k = 0; k < 3; ++k) sum += std::abs((*one)[k] - (*other)[k]);
      compared += 3;
    }
  }
  INFO("of " << total << " places " << opaque << " are opaque; mean difference " << sum / compared);
  CHECK(opaque == total);  // lakes are black in infrared, and no voids
  CHECK(compared > 3 * total * 9 / 10);
  CHECK(sum / compared < 4);
}

}  // namespace cairn
