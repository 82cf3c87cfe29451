#include "runtime/viewer/object_edits.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/object_pack.h"
#include "tests/support/test_data.h"

namespace cairn::viewer {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Placement house_at(LonLat place) {
  return {place, "house", 30, 1.5, {}};
}

}  // namespace

TEST_CASE("each placement is in the file at once, and is what the next session reads") {
  const test::TempDir dir;
  const auto file = placements_path(dir.path() / "alps.cairn");
  CHECK(file.filename() == "alps.cairn.objects.json");
  Result<ObjectEdits> edits = ObjectEdits::open(file);
  REQUIRE(edits.ok());
  CHECK(edits->all().empty());
  CHECK(!std::filesystem::exists(file));
  REQUIRE(edits->place(house_at({10.25, 45.5})).ok());
  REQUIRE(edits->place(house_at({-179.999, -89.5})).ok());
  Placement turned = edits->all()[0];
  turned.heading_deg = 200;
  REQUIRE(edits->change(0, turned).ok());
  Result<ObjectEdits> again = ObjectEdits::open(file);
  REQUIRE(again.ok());
  REQUIRE(again->all().size() == 2);
  CHECK(again->all()[0].at.lon == 10.25);
  CHECK(again->all()[0].heading_deg == 200);
  CHECK(again->all()[1].model == "house");
  CHECK(again->all()[1].scale == 1.5);
  CHECK(!again->can_undo());
  REQUIRE(edits->remove(1).ok());
  CHECK(ObjectEdits::open(file)->all().size() == 1);
  for (const std::size_t left : {2u, 2u, 1u, 0u}) {
    REQUIRE(edits->undo().ok());
    CHECK(edits->all().size() == left);
    CHECK(ObjectEdits::open(file)->all().size() == left);
  }
  CHECK(!edits->can_undo());
  CHECK(!std::filesystem::exists(file.string() + ".part"));
}

TEST_CASE("what the viewer does not know of a placement stays in the file") {
  const test::TempDir dir;
  const auto file = dir.path() / "p.objects.json";
  std::ofstream(file) << R"({"type":"FeatureCollection","features":[{"type":"Feature","id":7,
    "geometry":{"type":"Point","coordinates":[1.5,2.5,99]},
    "properties":{"model":"oak","mode":"absolute","height":12.5,"note":"by hand"}}]})";
  Result<ObjectEdits> edits = ObjectEdits::open(file);
  REQUIRE(edits.ok());
  REQUIRE(edits->place(house_at({3, 4})).ok());
  const nlohmann::json json = nlohmann::json::parse(text_of(file));
  REQUIRE(json["features"].size() == 2);
  CHECK(json["features"][0]["id"] == 7);
  CHECK(json["features"][0]["geometry"]["coordinates"][2] == 99);
  CHECK(json["features"][0]["properties"]["note"] == "by hand");
  CHECK(json["features"][0]["properties"]["mode"] == "absolute");
}

TEST_CASE("a file that is no collection of placements is an error, and stays as it is") {
  const test::TempDir dir;
  const auto file = dir.path() / "p.objects.json";
  for (
      const char* text :
      {"", "[]", "{\"type\":\"FeatureCollection\"}",
       R"({"type":"FeatureCollection","features":[{"geometry":{"type":"Point","coordinates":[1,2]},"properties":{}}]})",
       R"({"type":"FeatureCollection","features":[{"geometry":{"type":"LineString","coordinates":[[1,2],[3,4]]},"properties":{"model":"a"}}]})",
       R"({"type":"FeatureCollection","features":[{"geometry":{"type":"Point","coordinates":[1,99]},"properties":{"model":"a"}}]})",
       R"({"type":"FeatureCollection","features":[{"geometry":{"type":"Point","coordinates":[1,2]},"properties":{"model":"a","scale":-1}}]})",
       R"({"type":"FeatureCollection","features":[{"geometry":null,"properties":null}]})",
       R"({"type":"FeatureCollection","features":[3]})"}) {
    CAPTURE(text);
    { std::ofstream(file, std::ios::trunc) << text; }
    const Result<ObjectEdits> edits = ObjectEdits::open(file);
    REQUIRE(!edits.ok());
    CHECK(edits.error().code == ErrorCode::bad_data);
    CHECK(edits.error().message.find("expected") != std::string::npos);
    CHECK(edits.error().message.find('\n') == std::string::npos);
    CHECK(text_of(file) == text);
  }
}

TEST_CASE("a change that cannot be written is taken back") {
  const test::TempDir dir;
  const auto file = dir.path() / "gone" / "p.objects.json";
  Result<ObjectEdits> edits = ObjectEdits::open(file);
  REQUIRE(edits.ok());
  CHECK(!edits->place(house_at({1, 2})).ok());
  CHECK(edits->all().empty());
}

TEST_CASE("placements become objects in their tiles, and unknown models are named") {
  const std::vector<std::shared_ptr<const ObjectModel>> models = {
      std::make_shared<const ObjectModel>(test::box_model("house", 5, 8, {200, 0, 0})),
      std::make_shared<const ObjectModel>(test::box_model("tower", 20, 120, {0, 200, 0}))};
  const std::vector<Placement> placements = {house_at({10.25, 45.5}),
                                             {{-180, 12}, "tower", 370, 1, {}},
                                             {{3, 4}, "moon", 0, 1, {}},
                                             {{179.9999999, 12}, "tower", -10, 1, {}},
                                             {{5, 90}, "house", 0, 1, {}}};
  const PlacedTiles placed = placed_tiles(placements, models, Body());
  CHECK(placed.unknown == std::vector<std::string>{"moon"});
  std::size_t objects = 0;
  for (const auto& tile : placed.tiles) {
    for (const StandingObject& object : tile->all()) {
      ++objects;
      ObjectHit hit;
      hit.tile = tile->tile();
      hit.object = object.placed;
      const auto number = placed.placement_of(hit);
      REQUIRE(number);
      const Placement& placement = placements[*number];
      const LonLat at = place_of(tile->tile(), object.placed);
      const double width = tile_width_degrees(tile->tile().level) / 65536;
      CHECK(std::abs(std::remainder(at.lon - placement.at.lon, 360.0)) <= width);
      CHECK(std::abs(at.lat - placement.at.lat) <= width);
      CHECK(tile->models()[object.slot]->name == placement.model);
      CHECK(std::abs(std::remainder(object.placed.heading_degrees() - placement.heading_deg, 360.0)) < 0.01);
      CHECK(object.placed.scale_factor() == Approx(placement.scale));
    }
  }
  CHECK(objects == 4);
}

}  // namespace cairn::viewer
