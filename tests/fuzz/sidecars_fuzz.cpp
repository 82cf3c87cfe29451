// Any bytes are read as what lies beside an image: a world file, a .prj, an .aux.xml.
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "builder/raster/pam_sidecar.h"
#include "builder/raster/world_file.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string_view text_of(std::span<const std::byte> input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

/// What the image's place is, with these bytes as the file of that ending beside it.
void place_image(const char* ending, std::span<const std::byte> input) {
  static const TempDir folder;
  const auto image = folder.path() / "a.png";
  std::ofstream(folder.path() / "a.pgw") << "0.1\n0\n0\n-0.1\n28\n37\n";
  std::ofstream(folder.path() / "a.prj") << "GEOGCS[\"WGS 84\",AUTHORITY[\"EPSG\",\"4326\"]]";
  std::ofstream(folder.path() / (std::string("a.") + ending), std::ios::binary) << text_of(input);
  const auto placed = georeference_beside(image, 10, 10, {.bounds = {}, .cache_bytes = 1024});
  if (!placed) REQUIRE(placed.error().message.find("a.p") != std::string::npos);
}

void world_file(std::span<const std::byte> input) {
  place_image("pgw", input);
}

void prj(std::span<const std::byte> input) {
  place_image("prj", input);
}

void wkt(std::span<const std::byte> input) {
  Georeference georeference;
  (void)set_crs_of_wkt(georeference, text_of(input));
  (void)name_of_wkt(text_of(input));
}

void pam(std::span<const std::byte> input) {
  (void)parse_pam(text_of(input), 1);
}

constexpr std::string_view kUtm =
    "PROJCS[\"WGS 84 / UTM zone 36N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
    "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION["
    "\"Transverse_Mercator\"],PARAMETER[\"central_meridian\",33],UNIT[\"metre\",1],AUTHORITY[\"EPSG\","
    "\"32636\"]]";

}  // namespace

TEST_CASE("no bytes make reading a world file or a .prj crash") {
  run_fuzz("world_file", world_file, {bytes_of("30\n0\n0\n-30\n500000\n4100000\n"), bytes_of("1e-9 0 0")},
           2000);
  run_fuzz("prj", prj, {bytes_of(kUtm)}, 2000);
  run_fuzz("wkt", wkt, {bytes_of(kUtm), bytes_of("GEOGCRS[\"WGS 84\",ID[\"EPSG\",4326]]")}, 20000);
}

TEST_CASE("no bytes make reading an .aux.xml crash") {
  run_fuzz("pam", pam,
           {bytes_of("<PAMDataset><SRS>x</SRS><PAMRasterBand band=\"1\"><NoDataValue>-9999</NoDataValue>"
                     "<Scale>0.5</Scale><Offset>1</Offset><UnitType>ft</UnitType></PAMRasterBand>"
                     "</PAMDataset>"),
            bytes_of("<!-- a --><PAMDataset><![CDATA[b]]></PAMDataset>")},
           20000);
}

}  // namespace cairn::test
