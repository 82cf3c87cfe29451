// Any bytes are opened as a GeoTIFF; and any bytes are taken for a GeoKey directory and its arrays.
#include <cstring>

#include <catch2/catch.hpp>

#include "builder/raster/pam_sidecar.h"
#include "builder/raster/tiff/geotiff_tags.h"
#include "tests/support/dem_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/raster_fuzz.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

void geotiff(std::span<const std::byte> input) {
  open_and_read("geotiff", "x.tif", input);
}

template <class T>
std::vector<T> as(std::span<const std::byte> bytes) {
  std::vector<T> out(bytes.size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
  return out;
}

void keys(std::span<const std::byte> input) {
  GeoTiffTags tags;
  const auto third = input.size() / 3;
  const auto doubles = as<double>(input.subspan(third, third));
  const auto text = as<char>(input.subspan(2 * third));
  parse_geo_keys(as<std::uint16_t>(input.first(third)), doubles, {text.data(), text.size()}, tags);
  tags.tiepoints = tags.pixel_scale = doubles;
  tags.gdal_metadata = tags.gdal_nodata = std::string(text.begin(), text.end());
  (void)georeference_of(tags, "x.tif").ok();
  (void)height_tags_of(tags, 1);
  (void)parse_pam(tags.gdal_metadata, 1);
}

std::vector<Bytes> tiff_seeds() {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  std::vector<Bytes> seeds;
  for (int i = 0; i < 12; ++i) {
    TiffRecipe recipe;
    recipe.columns = 20 + i, recipe.rows = 18;
    recipe.tile = i % 2 == 0 ? 0 : 16;
    recipe.compression = i % 3 == 0 ? 1 : i % 3 == 1 ? 8 : 5;
    recipe.big_tiff = i % 4 == 1;
    recipe.big_endian = i % 4 == 2;
    recipe.mask = i == 5;
    recipe.bands = i == 7 ? 3 : 1;
    recipe.planar = i == 7;
    recipe.type = i == 8 ? SampleType::float32 : i == 9 || i == 7 ? SampleType::uint8 : SampleType::int16;
    recipe.photometric = i == 7 ? 2 : i == 9 ? 3 : 1;
    recipe.sample = [](int, std::int64_t c, std::int64_t r) {
      return static_cast<double>(test_height(c, r) & 127);
    };
    recipe.nodata = "-9999";
    recipe.citation = "WGS 84";
    recipe.gdal_metadata = "<Item role=\"scale\">2</Item>";
    write_tiff(path, recipe);
    seeds.push_back(read_bytes(path));
  }
  return seeds;
}

}  // namespace

TEST_CASE("no bytes make reading a GeoTIFF or its keys crash") {
  run_fuzz("geotiff", geotiff, tiff_seeds(), 6000);
  std::vector<std::uint16_t> directory{1,    1, 0, 4, 1024, 0,     1, 1, 3072, 0,     1, 32767,
                                       3075, 0, 1, 1, 3080, 34736, 1, 2, 1026, 34737, 4, 0};
  Bytes seed(directory.size() * 6);
  std::memcpy(seed.data(), directory.data(), directory.size() * 2);
  run_fuzz("geotiff_keys", keys, {seed}, 20000);
}

}  // namespace cairn::test
