// How images lie over one another, and what of them is stored: feathering, alpha, voids, one-colour tiles.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <catch2/catch.hpp>

#include "builder/export/texture_file.h"
#include "cairn/build.h"
#include "cairn/texture_tile.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"
#include "tests/support/texture_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using test::TempDir;
using test::TiffRecipe;
using test::write_tiff;

using Colour = std::function<double(int band, std::int64_t c, std::int64_t r)>;

// A square image whose north-western corner lies at (lon, lat).
TiffRecipe square(double lon, double lat, int side, double pixel, int bands, Colour colour) {
  TiffRecipe recipe;
  recipe.columns = recipe.rows = side;
  recipe.bands = bands;
  recipe.type = SampleType::uint8;
  recipe.photometric = 2;
  if (bands == 4) recipe.extra_samples = {2};
  recipe.pixel_scale = {pixel, pixel, 0};
  recipe.tiepoint = {0, 0, 0, lon, lat, 0};
  recipe.sample = std::move(colour);
  return recipe;
}

Colour plain(int red, int green, int blue) {
  return [=](int band, std::int64_t, std::int64_t) { return band == 0 ? red : band == 1 ? green : blue; };
}

fs::path bake(const TempDir& dir, const std::vector<fs::path>& images, double feather = 0) {
  BuildOptions options;
  options.imagery.inputs = images;
  options.imagery.feather_pixels = feather;
  options.session.target = dir.path() / "a.cairn";
  options.grid.tile_size = 257;
  options.session.threads = 2;
  options.session.force = true;
  const auto report = build(options, [](const Progress&) { return true; });
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
  return options.session.target;
}

std::size_t tiles_of_format(test::TexturePack& pack, int level, TextureFormat format) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < pack.pack().entry_count(); ++i) {
    const IndexEntry entry = pack.pack().entry(i);
    if (entry.layer != Layer::imagery || entry.id.level != level || (entry.flags & kConstant) != 0) continue;
    const auto tile = read_texture_tile(pack.pack(), entry);
    REQUIRE(tile.ok());
    count += tile->format == format;
  }
  return count;
}

}  // namespace

TEST_CASE(
    "a feathered image fades over that many of its pixels into the one beneath, and not where there is "
    "none") {
  const TempDir dir;
  constexpr double kPixel = 0.002;  // of the upper images
  write_tiff(dir.path() / "blue.tif", square(10, 50, 256, 0.008, 3, plain(0, 0, 200)));
  write_tiff(dir.path() / "red.tif", square(10.6, 49.5, 256, kPixel, 3, plain(200, 0, 0)));
  // Its eastern half lies beyond the blue one.
  write_tiff(dir.path() / "green.tif", square(11.8, 49.5, 256, kPixel, 3, plain(0, 200, 0)));
  const double feather = GENERATE(0.0, 40.0);
  test::TexturePack pack(
      bake(dir, {dir.path() / "blue.tif", dir.path() / "red.tif", dir.path() / "green.tif"}, feather));
  const auto at = [&](double lon, double lat) {
    const auto colour = pack.colour({lon, lat});
    REQUIRE(colour.has_value());
    return *colour;
  };
  const double lat = 49.25, rim = 10.6, end = 11.8 + 256 * kPixel;
  CHECK(at(rim - 3 * kPixel, lat)[2] > 190);
  CHECK(at(rim + (feather + 3) * kPixel, lat)[0] > 190);
  CHECK(at(rim + (feather + 3) * kPixel, lat)[2] < 12);
  CHECK(at(end - 4 * kPixel, lat)[1] > 190);  // no blue beneath: full green up to the rim
  int before = 0;
  for (double pixels = 1; pixels < feather; pixels += 3) {
    const auto colour = at(rim + pixels * kPixel, lat);
    CHECK(colour[0] >= before - 3);
    before = colour[0];
    // Shares of light: sRGB's 200 is 0.578 of it, and a code v is about (v/255)^2.2.
    CHECK(std::pow(colour[0] / 255.0, 2.2) / 0.578 == Approx(pixels / feather).margin(0.06));
    CHECK(std::pow(colour[2] / 255.0, 2.2) / 0.578 == Approx(1 - pixels / feather).margin(0.06));
  }
}

TEST_CASE("partial alpha makes a tile BC3 and stays what it was; opaque tiles beside it stay BC1") {
  const TempDir dir;
  constexpr int kSide = 1024;
  write_tiff(dir.path() / "x.tif",
             square(10, 50, kSide, 0.0005, 4, [](int band, std::int64_t c, std::int64_t r) {
               if (band == 3) return c < kSide / 4 ? 128.0 : 255.0;
               return static_cast<double>(80 + (c / 2 + r / 3 + 20 * band) % 90);
             }));
  test::TexturePack pack(bake(dir, {dir.path() / "x.tif"}));
  const int finest = pack.finest();
  CHECK(tiles_of_format(pack, finest, TextureFormat::bc1) > 0);
  CHECK(tiles_of_format(pack, finest, TextureFormat::bc3) > 0);
  const TileId id = tile_at({10.05, 49.75}, finest);
  const auto* mips = pack.mips(id);
  REQUIRE(mips != nullptr);
  CHECK((pack.pack().find(Layer::imagery, id)->flags & kHasAlpha) != 0);
  int furthest = 0;
  for (std::size_t i = 3; i < mips->front().size(); i += 4)
    furthest = std::max(furthest, std::abs(mips->front()[i] - 128));
  CHECK(furthest <= 1);
}

TEST_CASE("voids never bleed into what is beside them, at any level or mip") {
  const TempDir dir;
  constexpr int kSide = 600;
  const bool by_alpha = GENERATE(true, false);
  TiffRecipe recipe =
      square(10, 50, kSide, 0.0005, by_alpha ? 4 : 3, [](int band, std::int64_t c, std::int64_t r) {
        const bool hole =
            (c - 200) * (c - 200) + (r - 260) * (r - 260) < 90 * 90 || (c / 7 + r / 5) % 11 == 0;
        return hole ? 0.0 : band == 3 ? 255.0 : 220.0;
      });
  if (!by_alpha) recipe.nodata.assign(1, '0');  // GCC 12 warns of = "0"
  write_tiff(dir.path() / "x.tif", recipe);
  test::TexturePack pack(bake(dir, {dir.path() / "x.tif"}));
  int darkest = 255;
  std::size_t empty = 0, seen = 0;
  for (std::size_t i = 0; i < pack.pack().entry_count(); ++i) {
    const auto* mips = pack.mips(pack.pack().entry(i).id);
    REQUIRE(mips != nullptr);
    for (const auto& mip : *mips) {
      for (std::size_t t = 0; t < mip.size(); t += 4) {
        empty += mip[t + 3] == 0;
        if (mip[t + 3] == 0) continue;
        ++seen;
        darkest = std::min({darkest, int{mip[t]}, int{mip[t + 1]}, int{mip[t + 2]}});
      }
    }
  }
  INFO(seen << " texels, " << empty << " empty");
  CHECK(seen > 100000);
  CHECK(empty > 10000);
  CHECK(darkest >= 215);
}

TEST_CASE("tiles of one colour cost an entry and no data") {
  const TempDir dir;
  write_tiff(dir.path() / "x.tif", square(10, 50, 1500, 0.0005, 3, plain(30, 90, 160)));
  test::TexturePack pack(bake(dir, {dir.path() / "x.tif"}));
  std::size_t constant = 0, finest = 0;
  for (std::size_t i = 0; i < pack.pack().entry_count(); ++i) {
    const IndexEntry entry = pack.pack().entry(i);
    if (entry.id.level == pack.finest()) ++finest;
    if ((entry.flags & kConstant) == 0) continue;
    ++constant;
    CHECK(entry.bytes == 0);
  }
  CHECK(finest >= 36);
  CHECK(constant >= finest / 2);  // but for those at the image's rim
  const auto colour = pack.colour({10.3, 49.7});
  REQUIRE(colour.has_value());
  CHECK(std::abs((*colour)[0] - 30) <= 1);
  CHECK(std::abs((*colour)[2] - 160) <= 1);
}

}  // namespace cairn
