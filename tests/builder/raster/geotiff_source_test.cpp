#include <cmath>
#include <random>
#include <thread>

#include <catch2/catch.hpp>
#include <tiffio.h>

#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

struct Variant {
  SampleType type;
  int compression;
  int predictor;
  int tile;
  bool big_endian;
  bool big_tiff;
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  int i = 0;
  for (const SampleType type :
       {SampleType::uint8, SampleType::int8, SampleType::uint16, SampleType::int16, SampleType::uint32,
        SampleType::int32, SampleType::float32, SampleType::float64})
    for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE,
                                  COMPRESSION_PACKBITS, COMPRESSION_ZSTD, COMPRESSION_LZMA})
      for (const int tile : {0, 32}) {
        const bool predicts = compression == COMPRESSION_LZW || compression == COMPRESSION_ADOBE_DEFLATE;
        const bool floating = type == SampleType::float32 || type == SampleType::float64;
        all.push_back({type, compression, predicts && i % 2 == 0 ? (floating ? 3 : 2) : 1, tile, i % 3 == 0,
                       i % 5 == 0});
        ++i;
      }
  return all;
}

double sample_of(SampleType type, std::int64_t column, std::int64_t row) {
  const int h = test_height(column, row);
  if (type == SampleType::uint8) return h & 255;
  if (type == SampleType::int8) return (h & 127) - 64;
  if (type == SampleType::uint16 || type == SampleType::uint32) return h + 400;
  return type == SampleType::float32 || type == SampleType::float64 ? h + 0.25 : h;
}

std::string opening_complaint(const fs::path& path) {
  // GDAL, where it is there, opens what cairn's own reader refuses for its CRS: the reader alone is asked.
  for (const RasterFormat* format : raster_formats()) {
    if (std::string(format->name) != "geotiff") continue;
    const auto source = format->open(path, {});
    return source ? "" : source.error().message;
  }
  return "no geotiff reader";
}

}  // namespace

TEST_CASE("TIFF posts of every type, packing, layout and byte order read as they were written") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  for (const Variant& v : variants()) {
    TiffRecipe recipe;
    recipe.type = v.type;
    recipe.compression = v.compression;
    recipe.predictor = v.predictor;
    recipe.tile = v.tile;
    recipe.big_endian = v.big_endian;
    recipe.big_tiff = v.big_tiff;
    recipe.sample = [&](int, std::int64_t c, std::int64_t r) { return sample_of(v.type, c, r); };
    write_tiff(path, recipe);
    INFO(to_string(v.type) << " compression " << v.compression << " predictor " << v.predictor << " tile "
                           << v.tile << " big-endian " << v.big_endian);
    // The smallest cache sends strips through scratch.
    for (const std::size_t cache : {std::size_t{64}, std::size_t{1} << 20}) {
      const auto source = opened(path, {.bounds = {}, .cache_bytes = cache});
      CHECK(source->info().type == v.type);
      CHECK(source->info().whole_metres == (v.type != SampleType::float32 && v.type != SampleType::float64));
      std::vector<float> window(37 * 41);
      REQUIRE(source->read_heights({51, 23, 37, 41}, window).ok());
      bool equal = true;
      for (int r = 0; r < 41; ++r)
        for (int c = 0; c < 37; ++c)
          equal = equal && window[static_cast<std::size_t>(r * 37 + c)] ==
                               static_cast<float>(sample_of(v.type, 51 + c, 23 + r));
      CHECK(equal);
    }
  }
}

TEST_CASE("Pixel-is-area and pixel-is-point put the posts half a pixel apart") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.tiepoint = {0, 0, 0, 10, 50, 0};
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.x0 == Approx(10.005));
  CHECK(opened(path)->info().georeference.y0 == Approx(49.995));
  recipe.keys[1025] = 2;
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.x0 == Approx(10));
  CHECK(opened(path)->info().georeference.y0 == Approx(50));
  recipe.tiepoint = {2, 3, 0, 10, 50, 0};
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.x0 == Approx(9.98));
  CHECK(opened(path)->info().georeference.y0 == Approx(50.03));
  recipe.tiepoint.clear();
  recipe.pixel_scale.clear();
  recipe.transformation = {0.01, 0, 0, 10, 0, -0.02, 0, 50, 0, 0, 0, 0, 0, 0, 0, 1};
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.dy == Approx(-0.02));
  CHECK(opened(path)->info().bounds.north == Approx(50));
}

TEST_CASE("Decimals cut off in a file are restored, turns of longitude taken away") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.keys[1025] = 2;
  recipe.columns = recipe.rows = 1201;
  recipe.pixel_scale = {0.000833333333, 0.000833333333, 0};
  recipe.tiepoint = {0, 0, 0, 350, 50, 0};
  write_tiff(path, recipe);
  const auto source = opened(path);
  CHECK(source->info().georeference.dx == 1.0 / 1200);
  CHECK(source->info().bounds.west == -10);
  CHECK(source->info().bounds.east == -9);
  CHECK(source->info().bounds.south == 49);
}

TEST_CASE(
    "Voids are the nodata tag within its rounding, the customary values, NaN, infinities, absurd heights") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.columns = 10, recipe.rows = 2;
  recipe.type = SampleType::float32;
  recipe.nodata = "-123.4";
  const std::vector<double> values{-123.4f, -9999,   -32768, -32767, NAN, INFINITY, -3.4028234663852886e38,
                                   32767,   -9998.5, 8848.86};
  recipe.sample = [&](int, std::int64_t c, std::int64_t) { return values[static_cast<std::size_t>(c)]; };
  write_tiff(path, recipe);
  auto heights = all_heights(*opened(path));
  for (std::size_t i = 0; i < 7; ++i) CHECK(std::isnan(heights[i]));
  CHECK(heights[7] == 32767);
  CHECK(heights[8] == -9998.5F);
  CHECK(heights[9] == 8848.86F);
  recipe.type = SampleType::int16;
  recipe.nodata = "32767";
  recipe.sample = [&](int, std::int64_t c, std::int64_t) {
    return std::vector{32767, -9999, -32768, -32767, 0, 1, -1, 5, 6, 7}[static_cast<std::size_t>(c)];
  };
  write_tiff(path, recipe);
  heights = all_heights(*opened(path));
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::isnan(heights[i]));
  for (std::size_t i = 4; i < 10; ++i) CHECK_FALSE(std::isnan(heights[i]));
}

TEST_CASE("An alpha band, a mask directory and tiles that were never written are voids") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.mask = true;
  write_tiff(path, recipe);
  auto heights = all_heights(*opened(path));
  CHECK(heights[0] == static_cast<float>(test_height(0, 0)));
  CHECK(std::isnan(heights[1]));
  recipe.mask = false;
  recipe.bands = 2;
  recipe.extra_samples = {EXTRASAMPLE_UNASSALPHA};
  recipe.sample = [](int band, std::int64_t c, std::int64_t r) {
    return band == 0 ? test_height(c, r) : c == 3 ? 0.0 : 1.0;
  };
  for (const bool planar : {false, true}) {
    recipe.planar = planar;
    write_tiff(path, recipe);
    heights = all_heights(*opened(path));
    CHECK(heights[2] == static_cast<float>(test_height(2, 0)));
    CHECK(std::isnan(heights[3]));
  }
  TiffRecipe sparse;
  sparse.tile = 32;
  sparse.nodata = "-5";
  sparse.leave_out_last_tile = true;
  write_tiff(path, sparse);
  CHECK(std::isnan(all_heights(*opened(path)).back()));
}

TEST_CASE("Scale, offset and feet become metres") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.gdal_metadata =
      "<GDALMetadata>\n  <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item>\n"
      "  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-100</Item>\n"
      "  <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.1</Item>\n</GDALMetadata>\n";
  write_tiff(path, recipe);
  CHECK(all_heights(*opened(path))[5] == Approx(test_height(5, 0) * 0.1 - 100));
  CHECK_FALSE(opened(path)->info().whole_metres);
  recipe.gdal_metadata.clear();
  recipe.keys[4099] = 9002;
  write_tiff(path, recipe);
  CHECK(all_heights(*opened(path))[5] == Approx(test_height(5, 0) * 0.3048));
  recipe.keys.erase(4099);
  recipe.gdal_metadata =
      "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey "
      "foot</Item></GDALMetadata>";
  write_tiff(path, recipe);
  CHECK(all_heights(*opened(path))[5] == Approx(test_height(5, 0) * 1200.0 / 3937));
  recipe.gdal_metadata =
      "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">furlong</Item></GDALMetadata>";
  write_tiff(path, recipe);
  CHECK(contains(complaint_of(path), "furlong"));
}

TEST_CASE("UTM north and south, spelt by code or by parameters, and Web Mercator are known") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.pixel_scale = {30, 30, 0};
  recipe.tiepoint = {0, 0, 0, 500000, 4649776, 0};
  const auto crs_of = [&](std::map<int, int> keys, std::map<int, double> doubles = {}) {
    recipe.keys = std::move(keys);
    recipe.double_keys = std::move(doubles);
    write_tiff(path, recipe);
    return opened(path)->info().georeference;
  };
  for (const auto& [code, zone, north] : {std::tuple{32633, 33, true},
                                          {32701, 1, false},
                                          {32760, 60, false},
                                          {26917, 17, true},
                                          {25832, 32, true}}) {
    const Georeference g = crs_of({{1024, 1}, {3072, code}});
    CHECK(g.crs == Georeference::Crs::utm);
    CHECK(g.utm_zone == zone);
    CHECK(g.utm_north == north);
  }
  CHECK(crs_of({{1024, 1}, {2048, 4326}, {3072, 32767}, {3074, 16133}}).utm_north == false);
  const Georeference spelt = crs_of({{1024, 1}, {2048, 4269}, {3072, 32767}, {3074, 32767}, {3075, 1}},
                                    {{3080, 15}, {3081, 0}, {3082, 500000}, {3083, 0}, {3092, 0.9996}});
  CHECK(spelt.utm_zone == 33);
  CHECK(crs_of({{1024, 1}, {3072, 3857}}).crs == Georeference::Crs::web_mercator);
}

TEST_CASE("Any other CRS with a code is found by PROJ") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.pixel_scale = {30, 30, 0};
  recipe.tiepoint = {0, 0, 0, 400000, 200000, 0};
  recipe.keys = {{1024, 1}, {3072, 27700}, {4096, 5701}};
  write_tiff(path, recipe);
  const Georeference osgb = opened(path)->info().georeference;
  CHECK(osgb.crs == Georeference::Crs::other);
  REQUIRE(osgb.transform != nullptr);
  CHECK(osgb.transform->name() == "OSGB36 / British National Grid");
  CHECK(osgb.transform->metres_of_unit() == 1);
  // The grid's central meridian, moved to WGS84: what gdaltransform says of 400000 200000.
  CHECK(osgb.place_of(-0.5, -0.5).lon == Approx(-2.00139926752659).margin(1e-9));
  recipe.keys = {{1024, 1}, {3072, 2231}};
  recipe.tiepoint = {0, 0, 0, 3000000, 1700000, 0};
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.transform->metres_of_unit() == Approx(1200.0 / 3937));
  recipe.pixel_scale = {0.01, 0.01, 0};
  recipe.tiepoint = {0, 0, 0, -100, 40, 0};
  recipe.keys = {{1024, 2}, {2048, 4267}};  // NAD27
  write_tiff(path, recipe);
  CHECK(opened(path)->info().georeference.crs == Georeference::Crs::other);
  recipe.tiepoint = {0, 0, 0, 145, -35, 0};
  recipe.keys = {{1024, 2}, {2048, 7844}};  // GDA2020, for PROJ equal to WGS84
  write_tiff(path, recipe);
  const Georeference gda = opened(path)->info().georeference;
  CHECK(gda.crs == Georeference::Crs::geographic);
  CHECK(gda.transform == nullptr);
}

TEST_CASE("Longitudes that a user-defined CRS counts from Ferro are not taken for Greenwich's") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  const std::map<int, int> keys = {{1024, 2}, {1025, 1}, {2048, 32767}, {2054, 9102}, {2056, 7030}};
  for (const auto& [key, value] : {std::pair{2051, 8909}, {2061, -18}}) {
    recipe.keys = keys;
    recipe.double_keys.clear();
    if (key == 2051) recipe.keys[key] = value;
    if (key == 2061) recipe.double_keys[key] = value;
    write_tiff(path, recipe);
    CHECK(contains(opening_complaint(path), "user-defined"));
    const std::string complaint = complaint_of(path);  // of GDAL and PROJ, where they are there
    if (!complaint.empty()) continue;
    const LonLat first = opened(path)->info().georeference.place_of(0, 0);
    CHECK(first.lon < 10.005 - 17.6);
    CHECK(first.lon > 10.005 - 18.01);
  }
}

TEST_CASE("A CRS that neither the keys nor PROJ know is refused by its name") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.pixel_scale = {30, 30, 0};
  recipe.tiepoint = {0, 0, 0, 400000, 200000, 0};
  const auto complaint = [&](std::map<int, int> keys, std::string citation,
                             std::map<int, double> doubles = {}) {
    recipe.keys = std::move(keys);
    recipe.citation = std::move(citation);
    recipe.double_keys = std::move(doubles);
    write_tiff(path, recipe);
    return opening_complaint(path);
  };
  CHECK(contains(complaint({{1024, 1}, {3072, 27701}}, "no grid"), "EPSG:27701"));
  CHECK(contains(complaint({{1024, 2}, {2048, 1111}}, ""), "EPSG:1111"));
  CHECK(contains(complaint({{1024, 3}, {2048, 4326}}, ""), "EPSG:4326"));
  CHECK(contains(complaint({{1024, 1}, {2048, 4326}, {3072, 32767}, {3075, 8}}, "Lambert"),
                 "user-defined CRS (Lambert)"));
  CHECK(contains(complaint({{1024, 1}, {2048, 4267}, {3072, 32767}, {3074, 16033}}, "NAD27 UTM 33"),
                 "NAD27 UTM 33"));
  CHECK(contains(complaint({{1024, 1}, {3072, 32633}, {3076, 9002}}, ""), "EPSG:9002"));
  CHECK(contains(complaint({{1024, 2}, {2048, 4326}, {2054, 9101}}, ""), "EPSG:9101"));
}

TEST_CASE("A turned GeoTIFF lies where its transformation says") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.transformation = {0.01, 0.002, 0, 10, 0.003, -0.01, 0, 50, 0, 0, 0, 0, 0, 0, 0, 1};
  write_tiff(path, recipe);
  const Georeference g = opened(path)->info().georeference;
  CHECK_FALSE(g.is_straight());
  CHECK(g.place_of(7, 4).lon == Approx(10 + 0.01 * 7.5 + 0.002 * 4.5));
  CHECK(g.place_of(7, 4).lat == Approx(50 + 0.003 * 7.5 - 0.01 * 4.5));
  const auto post = g.post_at(g.place_of(7, 4));
  CHECK(post.column == Approx(7));
  CHECK(post.row == Approx(4));
}

TEST_CASE("A GeoTIFF without a place, off the Earth or larger than its file is refused") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  const auto complaint = [&](auto change) {
    TiffRecipe recipe;
    change(recipe);
    write_tiff(path, recipe);
    const std::string text = opening_complaint(path);
    CHECK(text.find('\n') == std::string::npos);
    CHECK(contains(text, path.string()));
    return text;
  };
  CHECK(contains(complaint([](TiffRecipe& r) { r.keys.clear(), r.tiepoint.clear(), r.pixel_scale.clear(); }),
                 "world file"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.tiepoint.clear(); }), "world file"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.pixel_scale.clear(); }), "pixel scale"));
  CHECK(contains(complaint([](TiffRecipe& r) {
                   r.transformation = {1, -2, 0, 0, 0.5, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
                 }),
                 "spacing"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.tiepoint[4] = 91; }), "-90…90"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.pixel_scale = {0, 0.01, 0}; }), "spacing"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.pixel_scale = {NAN, 0.01, 0}; }), "spacing"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.pixel_scale = {10, 0.01, 0}; }), "360"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.tiepoint[3] = INFINITY; }), "origin"));
  CHECK(contains(complaint([](TiffRecipe& r) { r.columns = 1; }), "2 to 2^31"));
  TiffRecipe recipe;
  write_tiff(path, recipe);
  Bytes bytes = read_bytes(path);
  bytes.resize(bytes.size() / 4);
  write_bytes(path, bytes);
  CHECK_FALSE(complaint_of(path).empty());
}

TEST_CASE("Threads that read windows of one packed TIFF at once agree with one that reads alone") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.columns = recipe.rows = 700;
  recipe.tile = 64;
  recipe.compression = COMPRESSION_ADOBE_DEFLATE;
  recipe.pixel_scale = {0.001, 0.001, 0};
  write_tiff(path, recipe);
  const auto source = opened(path, {.bounds = {}, .cache_bytes = 64 * 64 * 2 * 9});
  const auto whole = all_heights(*source);
  std::atomic<int> wrong = 0;
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      std::mt19937 random(t);
      std::vector<float> window(90 * 70);
      for (int i = 0; i < 100; ++i) {
        const std::int64_t c = random() % 610, r = random() % 630;
        if (!source->read_heights({c, r, 90, 70}, window).ok()) ++wrong;
        for (std::int64_t y = 0; y < 70; ++y)
          for (std::int64_t x = 0; x < 90; ++x)
            wrong += window[static_cast<std::size_t>(y * 90 + x)] !=
                     whole[static_cast<std::size_t>((r + y) * 700 + c + x)];
      }
    });
  threads.clear();
  CHECK(wrong == 0);
}

}  // namespace cairn::test
