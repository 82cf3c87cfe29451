#include "cairn/vertical_conversion.h"

#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/terrain.h"
#include "format/pack_writer.h"
#include "tests/support/flight_pack.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr double kScale = 0.003;

double plane_m(LonLat place) {
  return 20 + 0.2 * place.lat;
}

/// A geoid of a post per 15 degrees in GeographicLib's format, whose undulations are plane_m(). Any
/// interpolation that is exact for planes gives them between the posts as well.
void write_geoid(const std::filesystem::path& path) {
  std::ofstream out(path, std::ios::binary);
  out << "P5\n# Description plane\n# Offset -108\n# Scale " << kScale << "\n24 13\n65535\n";
  for (int row = 0; row < 13; ++row) {
    const auto value = static_cast<unsigned>(std::lround((plane_m({0, 90.0 - 15 * row}) + 108) / kScale));
    for (int column = 0; column < 24; ++column) {
      out.put(static_cast<char>(value >> 8)).put(static_cast<char>(value & 255));
    }
  }
}

PackReader pack_of(VerticalDatum datum, const std::filesystem::path& path) {
  PackHeader header = test::test_header();
  header.vertical_datum = datum;
  auto writer = PackWriter::create(path, header);
  REQUIRE(writer.ok());
  REQUIRE(writer->finish(test::test_metadata(header, {})).ok());
  return std::move(*PackReader::open(path));
}

TEST_CASE("Heights of an orthometric pack become ellipsoidal by the geoid's undulation, and back") {
  const test::TempDir dir;
  const auto geoid = dir.path() / "plane.pgm";
  write_geoid(geoid);
  const PackReader pack = pack_of(VerticalDatum::egm96, dir.path() / "egm96.cairn");
  const auto conversion = VerticalConversion::open(pack, geoid);
  REQUIRE(conversion.ok());
  for (const LonLat place : {LonLat{28.5, 37}, LonLat{-179.9, -52}, LonLat{388.5, 3}, LonLat{7, 74}}) {
    const double ellipsoidal = conversion->to_ellipsoid(place, 1000);
    CHECK(ellipsoidal == Approx(1000 + plane_m(place)).margin(kScale));
    CHECK(conversion->from_ellipsoid(place, ellipsoidal) == Approx(1000).margin(1e-9));
  }
}

TEST_CASE("Heights of an ellipsoidal pack stay as they are, whatever the geoid") {
  const test::TempDir dir;
  const PackReader pack = pack_of(VerticalDatum::ellipsoid, dir.path() / "ellipsoid.cairn");
  const auto conversion = VerticalConversion::open(pack, dir.path() / "absent.pgm");
  REQUIRE(conversion.ok());
  CHECK(conversion->to_ellipsoid({28.5, 37}, 1000) == 1000);
  CHECK(conversion->from_ellipsoid({28.5, 37}, 1000) == 1000);
}

TEST_CASE("Heights are not converted without the datum and its geoid") {
  const test::TempDir dir;
  const PackReader unknown = pack_of(VerticalDatum::unknown, dir.path() / "unknown.cairn");
  const PackReader egm96 = pack_of(VerticalDatum::egm96, dir.path() / "egm96.cairn");
  const auto code_of = [](const Result<VerticalConversion>& result) {
    REQUIRE_FALSE(result.ok());
    return result.error().code;
  };
  const auto geoid = dir.path() / "plane.pgm";
  write_geoid(geoid);
  CHECK(code_of(VerticalConversion::open(unknown, geoid)) == ErrorCode::usage);
  CHECK(code_of(VerticalConversion::open(egm96)) == ErrorCode::usage);
  CHECK(code_of(VerticalConversion::open(egm96, dir.path() / "geoid.tif")) == ErrorCode::usage);
  CHECK(code_of(VerticalConversion::open(egm96, dir.path() / "absent.pgm")) == ErrorCode::bad_data);
  std::filesystem::resize_file(geoid, 100);
  CHECK(code_of(VerticalConversion::open(egm96, geoid)) == ErrorCode::bad_data);
}

TEST_CASE("The ground's height plus a clearance is an eye at that clearance above the drawn ground") {
  const test::FlightPack flight;
  const auto pack = flight.open();
  TerrainOptions options;
  options.cache_bytes = 64u << 20;
  auto terrain = Terrain::open(pack, options);
  REQUIRE(terrain.ok());
  ViewState view;
  view.eye = test::FlightPack::kMiddle;
  view.height_m = 5000;
  for (int frame = 0; !terrain->update(view, 0.01).is_complete && frame < 1000; ++frame) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto ground_m = terrain->ground_height_m(view.eye);
  REQUIRE(ground_m.has_value());
  view.height_m = *ground_m + 2;
  const glm::dvec3 above = camera_frame(view).position - to_geocentric(view.eye, *ground_m);
  CHECK(glm::dot(above, local_frame(view.eye).up) == Approx(2).margin(1e-6));

  const test::TempDir dir;
  write_geoid(dir.path() / "plane.pgm");
  const PackReader egm96 = pack_of(VerticalDatum::egm96, dir.path() / "egm96.cairn");
  const auto conversion = VerticalConversion::open(egm96, dir.path() / "plane.pgm");
  REQUIRE(conversion.ok());
  const double eye_above_ellipsoid_m = *ground_m + plane_m(view.eye) + 2;
  CHECK(conversion->from_ellipsoid(view.eye, eye_above_ellipsoid_m) == Approx(view.height_m).margin(kScale));
}

}  // namespace
}  // namespace cairn
