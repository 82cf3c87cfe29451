#include <cmath>
#include <cstdio>

#include <catch2/catch.hpp>
// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>
#include <png.h>

#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr int kColumns = 60, kRows = 40;

/// Grey of 16 bits; other formats through libpng's simple writer.
void write_grey16(const fs::path& path, bool interlaced) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, kColumns, kRows, 16, PNG_COLOR_TYPE_GRAY,
               interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
  png_write_info(png, info);
  std::vector<std::vector<png_byte>> rows(kRows);
  std::vector<png_bytep> pointers;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      rows[static_cast<std::size_t>(r)].push_back(static_cast<png_byte>((test_height(c, r) + 400) >> 8));
      rows[static_cast<std::size_t>(r)].push_back(static_cast<png_byte>((test_height(c, r) + 400) & 255));
    }
    pointers.push_back(rows[static_cast<std::size_t>(r)].data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

void write_png(const fs::path& path, png_uint_32 format, const std::vector<std::uint8_t>& pixels,
               const void* colours = nullptr, unsigned entries = 0) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = kColumns, image.height = kRows, image.format = format, image.colormap_entries = entries;
  REQUIRE(png_image_write_to_file(&image, path.c_str(), 0, pixels.data(), 0, colours) != 0);
}

void write_jpeg(const fs::path& path, int bands, J_COLOR_SPACE space) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  jpeg_stdio_dest(&jpeg, file);
  jpeg.image_width = kColumns, jpeg.image_height = kRows, jpeg.input_components = bands,
  jpeg.in_color_space = space;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<JSAMPLE> row(static_cast<std::size_t>(kColumns * bands));
  while (jpeg.next_scanline < jpeg.image_height) {
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = static_cast<JSAMPLE>(i % static_cast<std::size_t>(bands) == 0 ? 200 : 2 * jpeg.next_scanline);
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::fclose(file);
}

}  // namespace

TEST_CASE("A 16-bit PNG with a world file is heights, interlaced or not, through memory or a file") {
  const TempDir folder;
  const auto path = folder.path() / "x.png";
  write_text(folder.path() / "x.pgw", "0.01\n0\n0\n-0.02\n10\n50\n");
  for (const bool interlaced : {false, true}) {
    write_grey16(path, interlaced);
    for (const std::size_t cache : {std::size_t{100}, std::size_t{1} << 20}) {
      const auto source = opened(path, {.bounds = {}, .cache_bytes = cache});
      CHECK(source->info().georeference.x0 == Approx(10));
      CHECK(source->info().georeference.dy == Approx(-0.02));
      CHECK(source->info().bounds.south == Approx(50 - 0.02 * (kRows - 1)));
      const auto heights = all_heights(*source);
      bool equal = true;
      for (int r = 0; r < kRows; ++r)
        for (int c = 0; c < kColumns; ++c)
          equal = equal && heights[static_cast<std::size_t>(r * kColumns + c)] ==
                               static_cast<float>(test_height(c, r) + 400);
      CHECK(equal);
    }
  }
}

TEST_CASE("World files go by any of their names, and a .prj says their CRS or is refused by name") {
  const TempDir folder;
  const auto path = folder.path() / "x.png";
  write_grey16(path, false);
  const std::string complaint = complaint_of(path);
  CHECK(complaint.find(".pgw, .pngw, .wld") != std::string::npos);
  CHECK(complaint.find('\n') == std::string::npos);
  for (const char* name : {"x.wld", "x.pngw", "x.PGW"}) {
    write_text(folder.path() / name, "30 0 0 -30 500000 4649776");
    CHECK(complaint_of(path).find("-90…90") != std::string::npos);
    const auto prj = folder.path() / "x.prj";
    write_text(prj,
               "PROJCS[\"WGS_1984_UTM_Zone_33N\",GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_"
               "1984\",6378137,298.25]]]]");
    CHECK(opened(path)->info().georeference.utm_zone == 33);
    write_text(
        prj,
        "PROJCS[\"whatever\",GEOGCS[\"WGS 84\",AUTHORITY[\"EPSG\",\"4326\"]],AUTHORITY[\"EPSG\",\"32735\"]]");
    CHECK(opened(path)->info().georeference.utm_north == false);
    write_text(prj, "PROJCRS[\"whatever\",BASEGEOGCRS[\"WGS 84\",ID[\"EPSG\",4326]],ID[\"EPSG\",3857]]");
    CHECK(opened(path)->info().georeference.crs == Georeference::Crs::web_mercator);
    write_text(prj,
               "GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,298.257223563]],"
               "PRIMEM[\"Ferro\",-17.6666666666666667],UNIT[\"Degree\",0.0174532925199433]]");
    write_text(folder.path() / name, "0.01 0 0 -0.01 27.6666666666666667 45");
    CHECK(complaint_of(path).find("found GCS_WGS_1984") != std::string::npos);  // PROJ's answer
    write_text(prj,
               "GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,298.257223563]],"
               "PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]],VERTCS[\"EGM96_Geoid\",VDATUM["
               "\"EGM96_Geoid\"],PARAMETER[\"Vertical_Shift\",0.0],PARAMETER[\"Direction\",1.0],UNIT["
               "\"Meter\",1.0]]");
    CHECK(opened(path)->info().georeference.crs == Georeference::Crs::geographic);
    CHECK(opened(path)->info().georeference.place_of(0, 0).lon == Approx(27.6666666666666667));
    write_text(prj, "EPSG:27700");
    CHECK(complaint_of(path).find("WKT") != std::string::npos);
    fs::remove(prj);
    fs::remove(folder.path() / name);
  }
  write_text(folder.path() / "x.pgw", "0.01 0.002 0.003 -0.01 10 50");
  const Georeference turned = opened(path)->info().georeference;
  CHECK(turned.place_of(2, 1).lon == Approx(10.023));
  CHECK(turned.place_of(2, 1).lat == Approx(49.994));
  write_text(folder.path() / "x.pgw", "0.01 0 0 -0.01 10");
  CHECK(complaint_of(path).find("line 6") != std::string::npos);
}

TEST_CASE("Bounds place an image by its outer edges") {
  const TempDir folder;
  write_grey16(folder.path() / "x.png", false);
  const auto source =
      opened(folder.path() / "x.png", {.bounds = GeoBounds{-180, -90, 180, 90}, .cache_bytes = 1 << 20});
  CHECK(source->info().georeference.x0 == Approx(-177));
  CHECK(source->info().georeference.y0 == Approx(87.75));
}

TEST_CASE("PNG colours: palettes are expanded, alpha stays unmultiplied, grey fills three channels") {
  const TempDir folder;
  const auto path = folder.path() / "x.png";
  write_text(folder.path() / "x.wld", "0.01 0 0 -0.01 10 50");
  write_png(path, PNG_FORMAT_RGBA, std::vector<std::uint8_t>(kColumns * kRows * 4, 77));
  CHECK(all_colours(*opened(path)) == std::vector<std::uint8_t>(kColumns * kRows * 4, 77));
  write_png(path, PNG_FORMAT_GRAY, std::vector<std::uint8_t>(kColumns * kRows, 99));
  auto rgba = all_colours(*opened(path));
  CHECK(std::vector<int>(rgba.begin(), rgba.begin() + 4) == std::vector{99, 99, 99, 255});
  const std::uint8_t palette[] = {1, 2, 3, 40, 50, 60, 7, 8, 9};
  write_png(path, PNG_FORMAT_RGB_COLORMAP, std::vector<std::uint8_t>(kColumns * kRows, 1), palette, 3);
  rgba = all_colours(*opened(path));
  CHECK(std::vector<int>(rgba.begin(), rgba.begin() + 4) == std::vector{40, 50, 60, 255});
  float h = 0;
  CHECK_FALSE(opened(path)->read_heights({0, 0, 1, 1}, {&h, 1}).ok());
}

TEST_CASE("JPEG colours come within the packing's loss; CMYK is refused") {
  const TempDir folder;
  const auto path = folder.path() / "x.jpg";
  write_text(folder.path() / "x.jgw", "0.01 0 0 -0.01 10 50");
  write_jpeg(path, 3, JCS_RGB);
  const auto rgba = all_colours(*opened(path));
  const std::size_t at = 4 * (20 * kColumns + 30);
  CHECK(std::abs(rgba[at] - 200) < 8);
  CHECK(std::abs(rgba[at + 1] - 40) < 8);
  CHECK(rgba[at + 3] == 255);
  write_jpeg(path, 1, JCS_GRAYSCALE);
  CHECK(opened(path)->info().bands == 1);
  write_jpeg(path, 4, JCS_CMYK);
  CHECK(complaint_of(path).find("CMYK") != std::string::npos);
}

TEST_CASE("A PNG or a JPEG cut anywhere is refused") {
  const TempDir folder;
  const OpenOptions options{.bounds = GeoBounds{0, 0, 1, 1}, .cache_bytes = 1 << 20};
  for (const char* name : {"x.png", "x.jpg"}) {
    const auto path = folder.path() / name;
    if (path.extension() == ".png") write_grey16(path, false);
    if (path.extension() == ".jpg") write_jpeg(path, 1, JCS_GRAYSCALE);
    const auto whole = read_bytes(path);
    CHECK(complaint_of(path, options).empty());
    for (std::size_t cut = 0; cut + 12 < whole.size(); cut += 1 + cut / 40) {
      INFO(name << " cut to " << cut << " of " << whole.size());
      write_bytes(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)});
      CHECK_FALSE(complaint_of(path, options).empty());
    }
  }
}

TEST_CASE("TIFF colours: a fourth band is alpha only where the file says so, and nodata is transparent") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe;
  recipe.columns = 4, recipe.rows = 2, recipe.bands = 4, recipe.type = SampleType::uint8,
  recipe.photometric = 2;
  recipe.nodata.assign(1, '0');
  recipe.extra_samples = {0};
  recipe.sample = [](int band, std::int64_t c, std::int64_t) {
    return c == 0 ? 0.0 : band == 3 ? 0.0 : c == 2 && band == 0 ? 0.0 : 10.0 * (band + 1);
  };
  const auto pixel = [](const std::vector<std::uint8_t>& rgba, std::size_t i) {
    return std::vector<int>(rgba.begin() + static_cast<std::ptrdiff_t>(4 * i),
                            rgba.begin() + static_cast<std::ptrdiff_t>(4 * i + 4));
  };
  using Pixel = std::vector<int>;
  for (const bool planar : {false, true})
    for (const int tile : {0, 16}) {
      recipe.planar = planar, recipe.tile = tile;
      write_tiff(path, recipe);
      const auto rgba = all_colours(*opened(path));
      CHECK(pixel(rgba, 0)[3] == 0);
      CHECK(pixel(rgba, 1) == Pixel{10, 20, 30, 255});
      CHECK(pixel(rgba, 2) == Pixel{0, 20, 30, 255});
    }
  // GDAL's note of near infrared, red, green and blue.
  recipe.photometric = 1, recipe.extra_samples = {0, 0, 0}, recipe.gdal_metadata = "<GDALMetadata>";
  for (const auto& [band, colour] : {std::pair{1, "Red"}, {2, "Green"}, {3, "Blue"}})
    recipe.gdal_metadata += "<Item name=\"COLORINTERP\" sample=\"" + std::to_string(band) +
                            "\" role=\"colorinterp\">" + colour + "</Item>";
  recipe.gdal_metadata += "</GDALMetadata>";
  for (const bool planar : {false, true}) {
    recipe.planar = planar;
    write_tiff(path, recipe);
    CHECK(pixel(all_colours(*opened(path)), 1) == Pixel{20, 30, 0, 255});
  }
  recipe.photometric = 2, recipe.gdal_metadata.clear();
  recipe.extra_samples = {2};
  write_tiff(path, recipe);
  CHECK(pixel(all_colours(*opened(path)), 1) == Pixel{10, 20, 30, 0});
  recipe.extra_samples = {1};
  recipe.sample = [](int band, std::int64_t, std::int64_t) { return band == 3 ? 128.0 : 64.0; };
  write_tiff(path, recipe);
  CHECK(pixel(all_colours(*opened(path)), 1) == Pixel{128, 128, 128, 128});
}

TEST_CASE("TIFF colours of 16 bits, few bits, palettes, YCbCr JPEG and inverted grey") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  const auto first_pixel = [&](const TiffRecipe& recipe) {
    write_tiff(path, recipe);
    const auto rgba = all_colours(*opened(path));
    return std::vector<int>(rgba.end() - 4, rgba.end());
  };
  using Pixel = std::vector<int>;
  TiffRecipe r;
  r.columns = r.rows = 16, r.rows_per_strip = 16;
  r.type = SampleType::uint16, r.bands = 3, r.photometric = 2;
  r.sample = [](int band, std::int64_t, std::int64_t) { return 257.0 * (band + 5); };
  CHECK(first_pixel(r) == Pixel{5, 6, 7, 255});
  r = {};
  r.columns = 13, r.rows = 3, r.type = SampleType::uint8;
  r.sample = [](int, std::int64_t c, std::int64_t) { return c % 2 == 0 ? 1.0 : 0.0; };
  r.bits = 1;
  CHECK(first_pixel(r) == Pixel{255, 255, 255, 255});
  r.photometric = 0;
  CHECK(first_pixel(r) == Pixel{0, 0, 0, 255});
  r.photometric = 1, r.bits = 4;
  CHECK(first_pixel(r) == Pixel{17, 17, 17, 255});
  r.photometric = 3, r.bits = 2;
  CHECK(first_pixel(r) == Pixel{1, 2, 1, 255});
  r.bits = 8;
  CHECK(first_pixel(r) == Pixel{1, 254, 1, 255});
  r = {};
  r.columns = r.rows = 32, r.tile = 32, r.type = SampleType::uint8, r.bands = 3, r.photometric = 6,
  r.compression = 7;
  r.sample = [](int band, std::int64_t, std::int64_t) { return band == 0 ? 200.0 : 90.0; };
  const auto jpeg = first_pixel(r);
  CHECK(std::abs(jpeg[0] - 200) < 8);
  CHECK(std::abs(jpeg[2] - 90) < 8);
  r = {};
  r.type = SampleType::uint8, r.bands = 4, r.photometric = 5;
  r.sample = [](int, std::int64_t, std::int64_t) { return 1.0; };
  write_tiff(path, r);
  std::vector<std::uint8_t> rgba(4);
  const Status cmyk = opened(path)->read_colours({0, 0, 1, 1}, rgba);
  REQUIRE(!cmyk);
  CHECK(cmyk.error().message.find("CMYK") != std::string::npos);
}

TEST_CASE("Real images hold the colours that GDAL reads", "[data]") {
  const auto data = real_data();
  if (!data) return;
  for (const char* name : {"swellendam_3420B_2010_328_RGB_LATLNG.tif", "m_4709963_se_14_1_20090818.tif",
                           "rasterio_RGB.byte_utm18n.tif", "bmng_world_topo_bathy_200411_5400x2700.jpg"}) {
    INFO(name);
    const auto path = *data / "imagery" / name;
    const auto source = opened(path, {.bounds = GeoBounds{-180, -90, 180, 90}, .cache_bytes = 32 << 20});
    const RasterInfo& info = source->info();
    std::vector<Post> posts;
    for (std::int64_t i = 0; i < 100; ++i) posts.push_back({i * 7919 % info.columns, i * 104729 % info.rows});
    std::vector<std::vector<double>> bands;
    for (int band = 1; band <= 3; ++band) {
      const auto values = gdal_values(path, posts, band);
      if (!values) return;
      bands.push_back(*values);
    }
    for (std::size_t i = 0; i < posts.size(); ++i) {
      std::vector<std::uint8_t> rgba(4);
      REQUIRE(source->read_colours({posts[i].column, posts[i].row, 1, 1}, rgba).ok());
      bool collar = info.nodata.has_value();
      for (std::size_t b = 0; b < 3; ++b) {
        CHECK(rgba[b] == bands[b][i]);
        collar = collar && bands[b][i] == *info.nodata;
      }
      if (info.bands < 4 || info.nodata) CHECK(rgba[3] == (collar ? 0 : 255));
    }
  }
}

}  // namespace cairn::test
