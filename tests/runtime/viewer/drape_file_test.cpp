#include "runtime/viewer/drape_file.h"

#include <string>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::viewer {
namespace {

const std::string kGeoJson = R"({"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"stroke": "#f00", "stroke-width": 5},
   "geometry": {"type": "LineString", "coordinates": [[8, 46], [8.5, 46.5, 1200], [190, -90]]}},
  {"type": "Feature", "properties": null, "geometry": {"type": "GeometryCollection", "geometries": [
    {"type": "Point", "coordinates": [1, 2]},
    {"type": "MultiPoint", "coordinates": [[1, 2], [3, 4]]},
    {"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]], [[5, 6], [7, 8]]]},
    {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]},
    {"type": "MultiPolygon", "coordinates": [[[[0, 0], [1, 0], [1, 1], [0, 0]], [[0.1, 0.1], [0.2, 0.1], [0.1, 0.1]]]]}]}},
  {"type": "Feature", "properties": {}, "geometry": null}]})";

const std::string kGpx = R"(<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">
  <wpt lat="46.5" lon="8.25"><name>hut</name></wpt>
  <rte><rtept lat="46" lon="8"/><rtept lat="46.1" lon="8"/></rte>
  <trk><trkseg><trkpt lat="47" lon="9"><ele>2000</ele></trkpt><trkpt lat="47.5" lon="9"/></trkseg><trkseg/></trk></gpx>)";

class Files {
 public:
  Result<Drape> read(const std::string& text) {
    const auto path = dir_.path() / ("drape-" + std::to_string(count_++));
    const auto bytes = std::as_bytes(std::span(text));
    test::write_bytes(path, {bytes.begin(), bytes.end()});
    return read_drapes({path});
  }

 private:
  test::TempDir dir_;
  int count_ = 0;
};

}  // namespace

TEST_CASE("lines and points of GeoJSON and GPX") {
  Files files;
  const Result<Drape> drape = files.read(kGeoJson);
  REQUIRE(drape.ok());
  REQUIRE(drape->lines.size() == 9);
  const DrapedLine& first = drape->lines[0];
  CHECK(first.places.size() == 3);
  CHECK(first.places[1].lat == 46.5);
  CHECK(first.colour == glm::vec3(1, 0, 0));
  CHECK(first.width_px == 5);
  CHECK(drape->lines[1].places.size() == 1);
  CHECK(drape->lines[1].width_px > 3);
  CHECK(drape->lines[8].places.size() == 3);  // the ring within
  const Result<Drape> gpx = files.read(kGpx);
  REQUIRE(gpx.ok());
  REQUIRE(gpx->lines.size() == 3);
  CHECK(gpx->lines[0].places[0].lon == 8.25);
  CHECK(gpx->lines[2].places[1].lat == 47.5);
}

TEST_CASE("what is no GeoJSON or GPX is named with its place") {
  Files files;
  const auto says = [&](const std::string& text, const std::string& words) {
    const Result<Drape> drape = files.read(text);
    CAPTURE(text);
    REQUIRE(!drape.ok());
    CHECK(drape.error().code == ErrorCode::bad_data);
    CHECK_THAT(drape.error().message, Catch::Contains(words));
  };
  says("", "expected GeoJSON or GPX");
  says("lon,lat", "expected GeoJSON or GPX");
  says("[]", "expected an object");
  says(R"({"type": "Feature", "geometry": {"type": "Point", "coordinates": [1, 91]}})",
       "coordinates: expected longitude");
  says(R"({"type": "LineString", "coordinates": [[1, 2], ["a", 3]]})", "coordinates[1]");
  says(R"({"type": "LineString", "coordinates": [[1, 2]]})", "two places");
  says(R"({"type": "Circle", "coordinates": [1, 2]})", "type of GeoJSON");
  says(R"({"type": "FeatureCollection", "features": [3]})", "features[0]");
  says(R"({"type": "Feature", "properties": {"stroke": "reddish"}, "geometry": null})", "#RRGGBB");
  says("<kml/>", "element gpx");
  says("<gpx><wpt lat='x' lon='3'/></gpx>", "wpt at byte");
  says("<gpx><wpt lat='1' lon='3'>", "byte");
  CHECK(read_drapes({"no-such-file"}).error().code == ErrorCode::failed);
}

TEST_CASE("a file that ends too early or has other bytes is read or refused, and nothing worse") {
  Files files;
  int refused = 0;
  for (const std::string& whole : {kGeoJson, kGpx}) {
    for (std::size_t size = 0; size < whole.size(); size += 7) {
      const Result<Drape> drape = files.read(whole.substr(0, size));
      refused += !drape.ok();
      if (!drape.ok()) CHECK(!drape.error().message.empty());
      std::string flipped = whole;
      flipped[size] = static_cast<char>(flipped[size] ^ 0x15);
      const Result<Drape> other = files.read(flipped);
      if (!other.ok()) CHECK(!other.error().message.empty());
    }
  }
  CHECK(refused > 150);
}

}  // namespace cairn::viewer
