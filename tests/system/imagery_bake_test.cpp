// Whole bakes of imagery, through build(): where things land, what meets at the edges, the same bytes.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <OpenImageIO/imageio.h>
#include <catch2/catch.hpp>
#include <png.h>

#include "builder/bake/journal.h"
#include "builder/export/texture_file.h"
#include "builder/imagery/texture_tile_encode.h"
#include "builder/raster/raster_source.h"
#include "cairn/build.h"
#include "format/pack_verify.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"
#include "tests/support/texture_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using test::bake;

BuildOptions options_for(std::vector<fs::path> images, const fs::path& target) {
  BuildOptions options = test::bake_options({}, target);
  options.imagery.inputs = std::move(images);
  return options;
}

void write_png(const fs::path& path, int columns, int rows, const std::vector<std::uint8_t>& rgba) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns), image.height = static_cast<png_uint_32>(rows);
  image.format = PNG_FORMAT_RGBA;
  REQUIRE(png_image_write_to_file(&image, path.c_str(), 0, rgba.data(), 0, nullptr) != 0);
}

// A spot of light, round in pixels, around a place between pixels.
void draw_spot(std::vector<std::uint8_t>& rgba, int columns, int rows, double x, double y) {
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double d2 = (c + 0.5 - x) * (c + 0.5 - x) + (r + 0.5 - y) * (r + 0.5 - y);
      auto* pixel = &rgba[static_cast<std::size_t>(4 * (r * columns + c))];
      const double light = 220 * std::exp(-d2 / 18);
      for (int k = 0; k < 3; ++k) pixel[k] = static_cast<std::uint8_t>(std::min(255.0, pixel[k] + light));
    }
  }
}

// The centre of light within 12 texels of the place, in texels east and south of it.
LonLat centre_of_light(test::TexturePack& pack, LonLat place) {
  const double step = tile_width_degrees(pack.finest()) / pack.size();
  const double u = std::fmod((place.lon + 180) / step, 1.0), v = std::fmod((90 - place.lat) / step, 1.0);
  double sum = 0, east = 0, south = 0;
  for (int dy = -12; dy <= 12; ++dy) {
    for (int dx = -12; dx <= 12; ++dx) {
      const auto colour = pack.colour(place, dx, dy);
      REQUIRE(colour.has_value());
      const double light = std::max(0, (*colour)[1] - 30);
      sum += light;
      east += light * (dx + 0.5 - u);
      south += light * (dy + 0.5 - v);
    }
  }
  REQUIRE(sum > 100);
  return {east / sum, south / sum};
}

struct Grid {
  const char* epsg;
  double x0, y0, dx, dy;  // of the north-western corner; of a pixel
};

}  // namespace

TEST_CASE("spots at known places land within half a texel, in every CRS") {
  const int columns = 900, rows = 800;
  const Grid grid =
      GENERATE(Grid{"EPSG:4326", 12.3, 47.1, 1.7e-5, 1.7e-5}, Grid{"EPSG:32633", 301234, 5211111, 1.3, 1.3},
               Grid{"EPSG:32755", 440000, 5800000, 2.0, 2.0}, Grid{"EPSG:3857", 1370000, 5960000, 1.9, 1.9});
  INFO(grid.epsg);
  std::vector<double> xy;
  for (const auto& [c, r] :
       {std::pair{120.3, 99.8}, {450.5, 400.0}, {803.2, 130.9}, {100.1, 690.4}, {777.7, 701.2}}) {
    xy.push_back(grid.x0 + c * grid.dx);
    xy.push_back(grid.y0 - r * grid.dy);
  }
  const auto places = test::proj_transform(grid.epsg, "EPSG:4326", xy);
  if (!places) return;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(4 * columns * rows), 10);
  for (std::size_t i = 3; i < rgba.size(); i += 4) rgba[i] = 255;
  for (std::size_t i = 0; i < xy.size(); i += 2)
    draw_spot(rgba, columns, rows, (xy[i] - grid.x0) / grid.dx, (grid.y0 - xy[i + 1]) / grid.dy);

  const test::TempDir dir;
  write_png(dir.path() / "spots.png", columns, rows, rgba);
  const fs::path tiff = dir.path() / "spots.tif";
  const std::string corners = std::to_string(grid.x0) + " " + std::to_string(grid.y0) + " " +
                              std::to_string(grid.x0 + columns * grid.dx) + " " +
                              std::to_string(grid.y0 - rows * grid.dy);
  if (!test::run_gdal("gdal_translate -q -of GTiff -a_srs " + std::string(grid.epsg) + " -a_ullr " + corners +
                      " " + (dir.path() / "spots.png").string() + " " + tiff.string()))
    return;
  bake(options_for({tiff}, dir.path() / "a.cairn"));
  test::TexturePack pack(dir.path() / "a.cairn");
  for (std::size_t i = 0; i < places->size(); i += 2) {
    const LonLat off = centre_of_light(pack, {(*places)[i], (*places)[i + 1]});
    INFO("spot " << i / 2 << " is " << off.lon << " texels east and " << off.lat << " south");
    CHECK(std::abs(off.lon) < 0.5);
    CHECK(std::abs(off.lat) < 0.5);
  }
}

TEST_CASE("tiles of real images meet without a seam, at every level and mip", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  const std::string name =
      GENERATE("swellendam_3420B_2010_328_RGB_LATLNG.tif", "m_4709963_se_14_1_20090818.tif",
               "bmng_world_topo_bathy_200411_5400x2700.jpg");
  BuildOptions options = options_for({*data / "imagery" / name}, dir.path() / "a.cairn");
  options.imagery.bounds = GeoBounds{-180, -90, 180, 90};
  bake(options);
  test::TexturePack pack(options.session.target);
  const auto levels = *pack.pack().levels(Layer::imagery);
  constexpr std::size_t kEnough = 64;  // pairs of texels that make a mean: a coarse level has few
  for (int mip = 0; pack.size() >> mip > 1; ++mip) {
    const auto all = test::seam_differences(pack, std::nullopt, mip);
    INFO(name << " mip " << mip << ": across " << all.across << " inside " << all.inside);
    REQUIRE(all.pairs > 0);
    CHECK(all.across <= 1.25 * all.inside);
    for (int level = std::max(levels.coarsest, levels.finest - 3); level <= levels.finest; ++level) {
      const auto d = test::seam_differences(pack, level, mip);
      INFO("level " << level << ": across " << d.across << " beside " << d.beside << " inside " << d.inside
                    << " of " << d.pairs);
      if (d.pairs >= kEnough) CHECK(d.across <= 1.25 * d.inside);
    }
  }
}

TEST_CASE("the same images give the same bytes, whatever the threads, the memory and the interruptions",
          "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  const fs::path image = *data / "imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif";
  BuildOptions options = options_for({image}, dir.path() / "whole.cairn");
  options.grid.tile_size = 257;
  options.imagery.quality = TextureQuality::fast;
  bake(options);
  const auto expected = test::read_bytes(options.session.target);
  const auto verified = verify_pack(options.session.target, {});
  REQUIRE(verified.ok());
  CHECK(verified->findings.empty());

  options.session.target = dir.path() / "again.cairn";
  options.session.threads = 1;
  options.session.memory_bytes = 100u << 20;
  bake(options);
  CHECK(test::read_bytes(options.session.target) == expected);
  fs::remove(options.session.target);

  options.session.resume = true;
  options.session.threads = 2;
  int calls = 0;
  CHECK_FALSE(build(options, [&](const Progress&) { return ++calls < 3; }).ok());
  REQUIRE_FALSE(fs::exists(options.session.target));
  const auto report = build(options, [](const Progress&) { return true; });
  REQUIRE(report.ok());
  CHECK(report->resumed);
  CHECK(test::read_bytes(options.session.target) == expected);
}

TEST_CASE(
    "a finer image lies on a coarser one, which shows through its holes, and where neither is there is no "
    "tile") {
  const test::TempDir dir;
  std::vector<std::uint8_t> blue, red;
  for (int i = 0; i < 64 * 64; ++i) blue.insert(blue.end(), {0, 0, 200, 255});
  for (int i = 0; i < 256 * 256; ++i) {
    const bool hole = i / 256 > 100 && i / 256 < 150 && i % 256 > 100 && i % 256 < 150;
    red.insert(red.end(), {200, 0, 0, static_cast<std::uint8_t>(hole ? 0 : 255)});
  }
  const auto georeferenced = [&](const std::string& name, int side, const std::vector<std::uint8_t>& rgba,
                                 const std::string& corners) {
    write_png(dir.path() / (name + ".png"), side, side, rgba);
    const std::string tiff = (dir.path() / (name + ".tif")).string();
    return test::run_gdal("gdal_translate -q -a_srs EPSG:4326 -a_ullr " + corners + " " +
                          (dir.path() / (name + ".png")).string() + " " + tiff);
  };
  if (!georeferenced("blue", 64, blue, "10 50 10.4 49.6")) return;
  if (!georeferenced("red", 256, red, "10.1 49.9 10.2 49.8")) return;
  BuildOptions options =
      options_for({dir.path() / "blue.tif", dir.path() / "red.tif"}, dir.path() / "a.cairn");
  options.grid.tile_size = 257;
  bake(options);
  test::TexturePack pack(options.session.target);
  const auto near_colour = [&](LonLat place, int r, int b) {
    const auto c = pack.colour(place);
    REQUIRE(c.has_value());
    CHECK(std::abs((*c)[0] - r) <= 8);
    CHECK(std::abs((*c)[2] - b) <= 8);
  };
  near_colour({10.11, 49.89}, 200, 0);
  near_colour({10.15, 49.85}, 0, 200);  // the hole
  near_colour({10.0995, 49.85}, 0, 200);
  const int finest = pack.finest();
  CHECK_FALSE(pack.pack().find(Layer::imagery, tile_at({10.35, 49.65}, finest)));  // finer than blue
  CHECK_FALSE(pack.pack().find(Layer::imagery, tile_at({11.5, 49.65}, 0)));
  const auto coarse = pack.pack().find(Layer::imagery, tile_at({10.35, 49.65}, 0));
  REQUIRE(coarse);
  CHECK((coarse->flags & kHasAlpha) != 0);
}

TEST_CASE("images that cannot be baked are errors that name the file") {
  const test::TempDir dir;
  std::vector<std::uint8_t> grey(4 * 300 * 300, 120);
  write_png(dir.path() / "plain.png", 300, 300, grey);
  const std::string png = (dir.path() / "plain.png").string(), tiff = (dir.path() / "bad.tif").string();
  const auto refused = [&](const fs::path& path) {
    const auto report =
        build(options_for({path}, dir.path() / "a.cairn"), [](const Progress&) { return true; });
    REQUIRE_FALSE(report.ok());
    CHECK(report.error().message.find(path.filename().string()) != std::string::npos);
    CHECK_FALSE(fs::exists(dir.path() / "a.cairn"));
    CHECK_FALSE(fs::exists(dir.path() / "a.cairn.part"));
  };
  refused(png);  // says nowhere where it lies
  const std::string place = " -a_srs EPSG:4326 -a_ullr 10 50 10.1 49.9 ";
  if (!test::run_gdal("gdal_translate -q -b 1 -b 2 -b 3 -co COMPRESS=JPEG -co TILED=YES" + place + png + " " +
                      tiff))
    return;
  auto bytes = test::read_bytes(tiff);
  SECTION("a damaged JPEG tile") {
    for (std::size_t i = bytes.size() / 3; i < bytes.size() / 2; ++i) bytes[i] = std::byte{0xFF};
    test::write_bytes(tiff, bytes);
    refused(tiff);
  }
  SECTION("a file that ends too soon") {
    bytes.resize(bytes.size() / 2);
    test::write_bytes(tiff, bytes);
    refused(tiff);
  }
  SECTION("CMYK") {
    REQUIRE(test::run_gdal("gdal_translate -q -co PHOTOMETRIC=CMYK" + place + png + " " + tiff));
    refused(tiff);
  }
}

}  // namespace cairn
