// What a file, its side-cars and the user say of a source: nodata, masks, units, datums, bands.

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <tiffio.h>

#include "builder/raster/pam_sidecar.h"
#include "builder/raster/source_overrides.h"
#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937.0;

TiffRecipe level_ground(double height, SampleType type = SampleType::float32) {
  TiffRecipe recipe;
  recipe.type = type;
  recipe.sample = [height](int, std::int64_t, std::int64_t) { return height; };
  return recipe;
}

std::string band_item(const std::string& element, const std::string& value) {
  return fmt::format("<PAMDataset><PAMRasterBand band=\"1\"><{0}>{1}</{0}></PAMRasterBand></PAMDataset>",
                     element, value);
}

OpenOptions with(const SourceOverrides& overrides) {
  OpenOptions options;
  options.overrides = overrides;
  return options;
}

}  // namespace

TEST_CASE("a nodata value of any size makes voids of the samples that have it, and of no others") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  constexpr double kMost = std::numeric_limits<double>::max(),
                   kInfinity = std::numeric_limits<double>::infinity();
  struct Case {
    SampleType type;
    double value;
    const char* tag;
  };
  for (const Case& c :
       {Case{SampleType::float64, -kMost, "-1.7976931348623157e+308"},
        Case{SampleType::float64, kMost, "1.7976931348623157e308"},
        Case{SampleType::float64, -kInfinity, "-inf"}, Case{SampleType::float64, 1e300, "1e300"},
        Case{SampleType::float32, kInfinity, "inf"}, Case{SampleType::float32, -kInfinity, "-inf"},
        Case{SampleType::float32, std::numeric_limits<float>::max(), "3.4028234663852886e+38"},
        Case{SampleType::float32, std::numeric_limits<float>::lowest(), "-3.40282e+38"}}) {
    INFO(c.tag);
    TiffRecipe recipe = level_ground(500, c.type);
    recipe.nodata = c.tag;
    recipe.sample = [&](int, std::int64_t column, std::int64_t) { return column == 3 ? c.value : 500.0; };
    write_tiff(path, recipe);
    const auto heights = all_heights(*opened(path));
    CHECK(std::isnan(heights[3]));
    CHECK(heights[2] == 500);
    CHECK(heights[4] == 500);
  }
}

TEST_CASE("a mask beside the file leaves out what it marks, in heights and in colours") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe mask = level_ground(0, SampleType::uint8);
  mask.keys.clear();
  mask.sample = [](int, std::int64_t column, std::int64_t) { return column == 5 ? 0.0 : 255.0; };
  write_tiff(fs::path(path).concat(".msk"), mask);
  write_tiff(path, level_ground(300));
  const auto heights = all_heights(*opened(path));
  CHECK(heights[4] == 300);
  CHECK(std::isnan(heights[5]));

  TiffRecipe image = level_ground(100, SampleType::uint8);
  image.bands = 3;
  image.photometric = PHOTOMETRIC_RGB;
  write_tiff(path, image);
  const auto colours = all_colours(*opened(path));
  CHECK(colours[4 * 4 + 3] == 255);
  CHECK(colours[4 * 5 + 3] == 0);

  mask.columns = 7;
  write_tiff(fs::path(path).concat(".msk"), mask);
  // GDAL, where it is there, opens what the reader of GeoTIFF refuses: the reader alone is asked.
  for (const RasterFormat* format : raster_formats()) {
    if (std::string(format->name) != "geotiff") continue;
    const auto refused = format->open(path, {});
    REQUIRE_FALSE(refused.ok());
    CHECK_THAT(refused.error().message,
               Catch::Contains("mask: expected the image's size, 100×80, found 7×80"));
  }
  CHECK_THAT(complaint_of(path), Catch::Contains("found 7×80"));  // also not by way of GDAL
}

TEST_CASE("nodata, unit, scale and offset count from a side-car; statistics do not") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  const fs::path sidecar = fs::path(path).concat(".aux.xml");
  TiffRecipe recipe = level_ground(1000);
  recipe.nodata = "-1";
  recipe.sample = [](int, std::int64_t column, std::int64_t) { return column == 3 ? -500.0 : 1000.0; };
  write_tiff(path, recipe);
  write_text(sidecar, band_item("NoDataValue", "-5.000000000000e+02"));
  CHECK(std::isnan(all_heights(*opened(path))[3]));
  write_text(sidecar, band_item("UnitType", "Feet"));
  CHECK(all_heights(*opened(path))[0] == Approx(1000 * kFoot));
  write_text(sidecar,
             "<PAMDataset><PAMRasterBand band=\"1\"><UnitType>ft</UnitType><Offset>100</Offset>"
             "<Scale>0.5</Scale></PAMRasterBand></PAMDataset>");
  CHECK(all_heights(*opened(path))[0] == Approx(600 * kFoot));
  write_text(sidecar, band_item("Metadata", "<MDI key=\"STATISTICS_MAXIMUM\">-1000</MDI>"));
  CHECK(all_heights(*opened(path))[0] == 1000);
  CHECK(all_heights(*opened(path))[3] == -500);
  write_text(sidecar, band_item("UnitType", "furlong"));
  CHECK(complaint_of(path).find("heights: expected metres or feet above a datum, found furlong") !=
        std::string::npos);

  const auto hgt = folder.path() / "N10E010.hgt";
  write_bytes(hgt, hgt_bytes(1201));
  const float plain = all_heights(*opened(hgt))[7];
  write_text(fs::path(hgt).concat(".aux.xml"), band_item("UnitType", "foot"));
  CHECK(all_heights(*opened(hgt))[7] == Approx(static_cast<double>(plain) * kFoot));
}

TEST_CASE("a side-car that was cut off anywhere is taken for what it still says") {
  const std::string whole =
      "<PAMDataset><SRS>x</SRS><PAMRasterBand band=\"2\"><NoDataValue>9</NoDataValue></PAMRasterBand>"
      "<PAMRasterBand band=\"1\"><Description/><NoDataValue le_hex_equiv=\"00\">-7</NoDataValue><UnitType/>"
      "</PAMRasterBand></PAMDataset>";
  CHECK(parse_pam(whole, 1).nodata == -7.0);
  CHECK(parse_pam(whole, 2).nodata == 9.0);
  CHECK_FALSE(parse_pam(whole, 3).nodata);
  CHECK(parse_pam(whole, 1).places);
  CHECK_FALSE(parse_pam(whole, 1).unit);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const auto pam = parse_pam(std::string_view(whole).substr(0, length), 1);
    CHECK((!pam.nodata || *pam.nodata == -7.0));
  }
}

TEST_CASE("units are known in any case, as the band says") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  const auto height_in = [&](const std::string& unit) {
    TiffRecipe recipe = level_ground(1000);
    recipe.gdal_metadata = fmt::format(
        "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">{}</Item></GDALMetadata>",
        unit);
    write_tiff(path, recipe);
    return static_cast<double>(all_heights(*opened(path))[0]);
  };
  for (const char* metre : {"m", "M", "Metre", "METERS", "meter", "unspecified"})
    CHECK(height_in(metre) == 1000);
  for (const char* foot : {"ft", "FT", "Foot", "FEET", "International Foot", "foot (International)"})
    CHECK(height_in(foot) == static_cast<float>(1000 * kFoot));
  for (const char* foot : {"US survey foot", "US_Survey_Foot", "ftUS", "us-ft", "Foot_US"})
    CHECK(height_in(foot) == static_cast<float>(1000 * kSurveyFoot));
  CHECK(height_in("cm") == 10);
  CHECK(height_in("decimeters") == 100);
  CHECK(height_in("Yards") == static_cast<float>(914.4));
  CHECK(height_in("fathom") == static_cast<float>(1828.8));
}

TEST_CASE("where a format has no units of bands, the vertical CRS says the heights' unit") {
  const TempDir folder;
  const std::string at = folder.path().string() + "/";
  write_tiff(at + "x.tif", level_ground(1000));
  for (const auto& [crs, metres] : {std::pair{"EPSG:4269+6360", kSurveyFoot}, {"EPSG:4269+8228", kFoot}}) {
    INFO(crs);
    if (!run_gdal(std::string("gdal_translate -of ENVI -a_srs ") + crs + " " + at + "x.tif " + at + "x.img"))
      return;
    CHECK(all_heights(*opened(at + "x.img"))[0] == static_cast<float>(1000 * metres));
  }
}

TEST_CASE("a .prj with a vertical CRS, OGC's or ESRI's, says the heights' unit and reference") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe = level_ground(1000);
  recipe.keys.clear();
  recipe.pixel_scale.clear();
  recipe.tiepoint.clear();
  write_tiff(path, recipe);
  write_text(folder.path() / "x.tfw", "0.01 0 0 -0.01 -105 40");
  const std::string plane =
      "GEOGCS[\"GCS_North_American_1983\",DATUM[\"D_North_American_1983\",SPHEROID[\"GRS_1980\",6378137.0,"
      "298.257222101]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]";
  const auto height_with = [&](const std::string& prj) {
    write_text(folder.path() / "x.prj", prj);
    return static_cast<double>(all_heights(*opened(path))[0]);
  };
  CHECK(height_with(plane) == 1000);
  CHECK_FALSE(opened(path)->info().vertical);
  const std::string esri =
      "VERTCS[\"NAVD88_height_(ftUS)\",VDATUM[\"North_American_Vertical_Datum_1988\"],"
      "PARAMETER[\"Vertical_Shift\",0.0],PARAMETER[\"Direction\",1.0],UNIT[\"Foot_US\",0.3048006096012192]]";
  for (const char* between : {",", ", \r\n"}) {
    CHECK(height_with(plane + between + esri) == Approx(1000 * kSurveyFoot));
    CHECK(opened(path)->info().vertical->name == "NAVD88 height");
  }
  const std::string ogc =
      "VERT_CS[\"NAVD88 height (ft)\",VERT_DATUM[\"North American Vertical Datum 1988\",2005],"
      "UNIT[\"foot\",0.3048],AXIS[\"Gravity-related height\",UP]]";
  CHECK(height_with("COMPD_CS[\"both\"," + plane + "," + ogc + "]") == Approx(1000 * kFoot));
  CHECK(opened(path)->info().vertical->name == "NAVD88 height");
  CHECK(static_cast<double>(all_heights(*opened(path, with({.unit = "m"})))[0]) == 1000);
}

TEST_CASE("an image's unit is not looked at, that of heights is") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe = level_ground(100, SampleType::uint8);
  recipe.gdal_metadata =
      "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">counts</Item></GDALMetadata>";
  write_tiff(path, recipe);
  CHECK(complaint_of(path).find("found counts") != std::string::npos);
  CHECK(all_colours(*opened(path))[0] == 100);
}

TEST_CASE("a vertical CRS is read as the reference of the heights") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  const auto reference = [&](int geographic, int vertical) {
    TiffRecipe recipe = level_ground(1);
    recipe.keys[2048] = geographic;
    if (vertical != 0) recipe.keys[4096] = vertical;
    write_tiff(path, recipe);
    return opened(path)->info().vertical;
  };
  CHECK_FALSE(reference(4326, 0));
  CHECK(reference(4326, 5773) == VerticalReference{"EGM96 height", VerticalDatum::egm96});
  CHECK(reference(4326, 3855) == VerticalReference{"EGM2008 height", VerticalDatum::unknown});
  CHECK(reference(4326, 5703) == VerticalReference{"NAVD88 height", VerticalDatum::unknown});
  CHECK(reference(4258, 5783) == VerticalReference{"DHHN92 height", VerticalDatum::unknown});  // by PROJ
  CHECK(reference(4979, 0) == VerticalReference{"WGS 84", VerticalDatum::ellipsoid});
  CHECK(reference(4937, 0) == VerticalReference{"ETRS89", VerticalDatum::ellipsoid});
  CHECK(reference(4326, 5030)->datum == VerticalDatum::ellipsoid);
}

TEST_CASE("what the user says of a source counts instead of what the file says") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe = level_ground(1);
  recipe.nodata = "7";
  for (const bool planar : {false, true}) {
    recipe.bands = 3;
    recipe.planar = planar;
    recipe.sample = [](int band, std::int64_t column, std::int64_t) {
      return 10.0 * band + static_cast<double>(column);
    };
    write_tiff(path, recipe);
    const auto second = all_heights(*opened(path, with({.band = 2, .nodata = 13.0})));
    CHECK(second[2] == 12);
    CHECK(std::isnan(second[3]));
    CHECK(second[4] == 14);
    CHECK(complaint_of(path, with({.band = 4})).find("expected band 4, found 3 bands") != std::string::npos);
  }
  recipe.bands = 1;
  recipe.sample = [](int, std::int64_t column, std::int64_t) { return static_cast<double>(column); };
  write_tiff(path, recipe);
  const auto scaled = all_heights(*opened(path, with({.scale = 2.0, .offset = 100.0, .unit = "ft"})));
  CHECK(static_cast<double>(scaled[5]) == Approx(110 * kFoot));
  CHECK(std::isnan(scaled[7]));
  CHECK(complaint_of(path, with({.unit = "furlong"})).find("found furlong") != std::string::npos);
  CHECK_FALSE(complaint_of(path, with({.scale = 0.0})).empty());
}

TEST_CASE("a CRS that the user names takes the place of the file's, also of one that is unknown") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  TiffRecipe recipe = level_ground(1);
  recipe.pixel_scale = {30, 30, 0};
  recipe.tiepoint = {0, 0, 0, 2'600'000, 1'200'000, 0};
  recipe.keys = {{1024, 1}, {1025, 1}, {3072, 32767}};
  write_tiff(path, recipe);
  CHECK_FALSE(complaint_of(path).empty());
  const auto bern = opened(path, with({.crs = "EPSG:2056"}));  // its origin is the old observatory of Bern
  CHECK(bern->info().bounds.west == Approx(7.4388).margin(0.001));
  CHECK(bern->info().bounds.north == Approx(46.951).margin(0.001));
  const auto with_heights = opened(path, with({.crs = "EPSG:2056+5728"}));
  CHECK(with_heights->info().vertical->name == "LN02 height");
  CHECK(static_cast<double>(all_heights(*opened(path, with({.crs = "EPSG:2231+6360"})))[0]) ==
        Approx(kSurveyFoot));
  CHECK(complaint_of(path, with({.crs = "EPSG:1"})).find("CRS: expected one that PROJ knows") !=
        std::string::npos);
}

TEST_CASE("of two rules that match a source the later one counts, field by field") {
  const std::vector<SourceRule> rules{
      {"*", {.nodata = -1.0, .unit = "m"}}, {"*_ft.tif", {.unit = "ft"}}, {"/data/b/*", {.priority = 3}}};
  CHECK(overrides_of("/data/a/x.tif", rules) == SourceOverrides{.nodata = -1.0, .unit = "m"});
  CHECK(overrides_of("/data/b/x_ft.tif", rules) ==
        SourceOverrides{.nodata = -1.0, .unit = "ft", .priority = 3});
  CHECK(overrides_of("x.tif", {}) == SourceOverrides{});
}

TEST_CASE("rules count for a packed raster by the archive's name") {
  const TempDir folder;
  const auto plain = folder.path() / "inside.tif", packed = folder.path() / "outside.zip";
  write_tiff(plain, level_ground(10));
  write_bytes(packed, zipped({{"inside.tif", read_bytes(plain)}}));
  OpenOptions options;
  options.rules = {{"outside*", {.unit = "ft"}}, {"inside*", {.unit = "km"}}};
  CHECK(static_cast<double>(all_heights(*opened(packed, options))[0]) == Approx(10 * kFoot));
}

TEST_CASE("images of 9 to 15 bits are scaled by their bits, not by their type's") {
  const TempDir folder;
  const auto wide = folder.path() / "wide.tif", narrow = folder.path() / "narrow.tif";
  for (const int bits : {9, 10, 11, 12, 15}) {
    TiffRecipe recipe;
    recipe.type = SampleType::uint16;
    recipe.bands = 3;
    recipe.photometric = PHOTOMETRIC_RGB;
    const double white = (1 << bits) - 1;
    recipe.sample = [white](int band, std::int64_t, std::int64_t) {
      return std::round((200.0 - 75 * band) / 255 * white);
    };
    write_tiff(wide, recipe);
    if (!run_gdal(fmt::format("gdal_translate -q -co NBITS={} {} {}", bits, wide.string(), narrow.string())))
      return;
    const auto colours = all_colours(*opened(narrow));
    INFO(bits);
    CHECK(std::abs(colours[0] - 200) <= 1);
    CHECK(std::abs(colours[1] - 125) <= 1);
    CHECK(std::abs(colours[2] - 50) <= 1);
  }
}

TEST_CASE("an image's samples go from the black to the white that the user says, alpha untouched") {
  const TempDir folder;
  const auto tif = folder.path() / "x.tif", vrt = folder.path() / "x.vrt";
  TiffRecipe recipe;
  recipe.type = SampleType::uint16;
  recipe.bands = 4;
  recipe.photometric = PHOTOMETRIC_RGB;
  recipe.extra_samples = {EXTRASAMPLE_UNASSALPHA};
  recipe.sample = [](int band, std::int64_t, std::int64_t) {
    constexpr std::array<double, 4> kBands{100, 1100, 3000, 65535};
    return kBands[static_cast<std::size_t>(band)];
  };
  write_tiff(tif, recipe);
  OpenOptions options;
  options.rules = {{"*", {.black = 200, .white = 2000}}};
  std::vector<std::filesystem::path> files{tif};
  if (run_gdal(fmt::format("gdal_translate -q -of VRT {} {}", tif.string(), vrt.string())))
    files.push_back(vrt);
  for (const auto& file : files) {
    const auto colours = all_colours(*opened(file, options));
    CHECK(colours[0] == 0);
    CHECK(colours[1] == 128);  // 255 · 900 / 1800
    CHECK(colours[2] == 255);
    CHECK(colours[3] == 255);
  }
}

TEST_CASE("GDAL's colour interpretation and palettes make the colours") {
  const TempDir folder;
  const auto tif = folder.path() / "x.tif", vrt = folder.path() / "x.vrt";
  TiffRecipe recipe = level_ground(0, SampleType::uint8);
  recipe.bands = 4;
  recipe.photometric = PHOTOMETRIC_MINISBLACK;
  recipe.extra_samples = {0, 0, 0};
  recipe.sample = [](int band, std::int64_t, std::int64_t) { return 10.0 * (band + 1); };
  write_tiff(tif, recipe);
  if (!run_gdal(fmt::format("gdal_translate -q -of VRT -colorinterp undefined,blue,green,red {} {}",
                            tif.string(), vrt.string())))
    return;
  const auto colours = all_colours(*opened(vrt));
  CHECK(colours[0] == 40);
  CHECK(colours[1] == 30);
  CHECK(colours[2] == 20);

  write_text(
      vrt,
      "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><SRS>EPSG:4326</SRS>"
      "<GeoTransform>10, 0.1, 0, 50, 0, -0.1</GeoTransform><VRTRasterBand dataType=\"Byte\" band=\"1\">"
      "<ColorInterp>Palette</ColorInterp><ColorTable><Entry c1=\"1\" c2=\"2\" c3=\"3\" c4=\"255\"/>"
      "<Entry c1=\"11\" c2=\"22\" c3=\"33\" c4=\"255\"/></ColorTable></VRTRasterBand></VRTDataset>");
  const auto indexed = all_colours(*opened(vrt));
  CHECK(indexed[0] == 1);
  CHECK(indexed[2] == 3);
}

}  // namespace cairn::test
