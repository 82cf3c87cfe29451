// Any bytes are read as files of places: each place and area that comes out keeps the rules, else there is
// one error.
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "builder/objects/place_feature.h"
#include "builder/objects/place_files.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

std::vector<std::byte> input_of(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

const PlaceVisitor kVisitor{[](const ObjectPlace& place) {
                              REQUIRE(check_place(place));
                              return Status();
                            },
                            [](const ScatterArea& area) {
                              REQUIRE(check_area(area));
                              return Status();
                            }};

void read_geojson_feature(std::span<const std::byte> input) {
  const auto* text = reinterpret_cast<const char*>(input.data());
  const auto json = nlohmann::json::parse(text, text + input.size(), nullptr, false);
  const Status status = read_feature(json, kVisitor);
  if (!status) REQUIRE(status.error().message.find("expected") != std::string::npos);
}

void read_csv(std::span<const std::byte> input) {
  static const TempDir dir;
  const auto file = dir.path() / "places.csv";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  const Status status = read_places(file, kVisitor);
  if (!status) REQUIRE(status.error().message.starts_with(file.string() + ": "));
}

}  // namespace

TEST_CASE("no bytes make reading a feature crash, and what it hands over keeps the rules") {
  run_fuzz(
      "object_feature", read_geojson_feature,
      {input_of(R"({"type":"Feature","properties":{"model":"a","heading":9,"scale":"2","mode":"ground"},)"
                R"("geometry":{"type":"MultiPoint","coordinates":[[1,2],[3,4,5]]}})"),
       input_of(
           R"({"properties":{"model":"a:2,b","density":5,"spacing":3,"seed":1,"max_slope":9},)"
           R"("geometry":{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[1,1]],[[0,0],[1,0],[0,1]]]]}})")},
      20000);
}

TEST_CASE("no bytes make reading a CSV of places crash, and what it hands over keeps the rules") {
  run_fuzz("object_csv", read_csv,
           {input_of("lon,lat,model,heading,scale,height,mode\n1,2,oak,90,1.5,3,absolute\n4,5,fir,,,,\n"),
            input_of("\xEF\xBB\xBFmodel, lat ,lon\r\n\"oak\",1,2\r\n")},
           3000);
}

}  // namespace cairn::test
