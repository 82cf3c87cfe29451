// Any bytes are opened as a zip archive and as a gzip file of a raster.
#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/raster_fuzz.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

void zip(std::span<const std::byte> input) {
  open_and_read("packed", "a.zip", input);
}

void gzip(std::span<const std::byte> input) {
  open_and_read("packed", "a.tif.gz", input);
}

}  // namespace

TEST_CASE("no bytes make reading a packed raster crash") {
  const TempDir folder;
  TiffRecipe recipe;
  recipe.columns = 20;
  recipe.rows = 10;
  write_tiff(folder.path() / "a.tif", recipe);
  const Bytes tiff = read_bytes(folder.path() / "a.tif");
  run_fuzz("packed_zip", zip,
           {zipped({{"a.tif", tiff}}), zipped({{"a.tfw", Bytes(9)}, {"b/a.tif", tiff, false}})}, 400);
  run_fuzz("packed_gzip", gzip, {gzipped(tiff)}, 200);
}

}  // namespace cairn::test
