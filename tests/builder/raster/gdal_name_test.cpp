// Names of GDAL's that are no paths: the file that they lead to, and the raster that they open.

#include "builder/raster/gdal_name.h"

#include <catch2/catch.hpp>

#include "builder/raster/expand_inputs.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

}  // namespace

TEST_CASE("a name of GDAL's leads to its file, a path or a slip does not") {
  const TempDir folder;
  const std::string file = (folder.path() / "a.nc").string(), odd = (folder.path() / "b:c.nc").string();
  write_text(file, "x");
  write_text(odd, "x");
  const auto leads_to = [](const std::string& name, const std::string& expected) {
    INFO(name);
    const auto found = file_of_gdal_name(name);
    CHECK((found ? found->string() : "") == expected);
  };
  leads_to("NETCDF:" + file + ":z", file);
  leads_to("NETCDF:\"" + file + "\":z", file);
  leads_to("NETCDF:" + file, file);
  leads_to("HDF5:\"" + file + "\"://group/z", file);
  leads_to("HDF5:" + file + "://group/z", file);
  leads_to("GTIFF_DIR:2:" + file, file);
  leads_to("NETCDF:" + odd + ":z", odd);
  leads_to("/vsizip/" + file + "/inside/z.tif", file);
  leads_to("/vsizip//vsigzip/" + file, file);
  const std::vector<std::string> others{file,
                                        odd,
                                        file + ":z",
                                        "NETCDF:nowhere.nc:z",
                                        "/vsicurl/https://x.org/a.tif",
                                        "/vsizip/",
                                        "/vsi",
                                        "NETCDF:",
                                        ":",
                                        "",
                                        "NETCDF:\"",
                                        "NETCDF::::"};
  for (const std::string& none : others) leads_to(none, "");
}

TEST_CASE("a raster opens by GDAL's name of it, and is an input of that name") {
  const TempDir folder;
  const fs::path plain = folder.path() / "x.tif", packed = folder.path() / "y.zip";
  write_tiff(plain, TiffRecipe{});
  write_bytes(packed, zipped({{"sub/x.tif", read_bytes(plain)}, {"other.tif", read_bytes(plain)}}));
  const std::string name = "/vsizip/" + packed.string() + "/sub/x.tif";
  CHECK(all_heights(*opened(name)) == all_heights(*opened(plain)));
  CHECK(all_heights(*opened("GTIFF_DIR:1:" + plain.string())) == all_heights(*opened(plain)));
  const std::vector<std::string> arguments{name};
  const auto inputs = expand_inputs(arguments, {});
  REQUIRE(inputs.ok());
  CHECK(inputs->files == std::vector<fs::path>{name});
  CHECK_FALSE(complaint_of("/vsizip/" + packed.string() + "/none.tif").empty());
}

}  // namespace cairn::test
