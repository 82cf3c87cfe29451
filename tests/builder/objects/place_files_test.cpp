// What files of places hand over, what they refuse, and how places are sorted.
#include "builder/objects/place_files.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "builder/objects/place_feature.h"
#include "builder/objects/place_store.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

struct Found {
  std::vector<ObjectPlace> places;
  std::vector<ScatterArea> areas;

  PlaceVisitor visitor() {
    return {[this](const ObjectPlace& place) { return places.push_back(place), Status(); },
            [this](const ScatterArea& area) { return areas.push_back(area), Status(); }};
  }
};

nlohmann::json square(const nlohmann::json& properties) {
  const nlohmann::json ring{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
  return {{"type", "Feature"},
          {"properties", properties},
          {"geometry", {{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}}}};
}

std::string refusal(const nlohmann::json& feature) {
  Found found;
  const Status status = read_feature(feature, found.visitor());
  return status ? "" : status.error().message;
}

}  // namespace

TEST_CASE("a polygon's properties are its rule, as numbers or as texts") {
  Found found;
  REQUIRE(read_feature(square({{"model", "fir:3, oak"},
                               {"density", "12.5"},
                               {"spacing", 4},
                               {"seed", 9},
                               {"min_scale", 0.5},
                               {"max_scale", 2},
                               {"max_slope", 30},
                               {"min_height", -10},
                               {"heading", nullptr},
                               {"owner", "anyone"}}),
                       found.visitor()));
  REQUIRE(found.areas.size() == 1);
  const ScatterRule& rule = found.areas[0].rule;
  REQUIRE(rule.models.size() == 2);
  CHECK((rule.models[0].model == "fir" && rule.models[0].weight == 3));
  CHECK((rule.models[1].model == "oak" && rule.models[1].weight == 1));
  CHECK((rule.per_hectare == 12.5 && rule.spacing_m == 4 && rule.seed == 9));
  CHECK((rule.min_scale == 0.5 && rule.max_scale == 2 && !rule.heading_degrees));
  CHECK((rule.limits.max_slope_deg == 30 && rule.limits.min_height_m == -10 && rule.limits.has_slope()));
  CHECK(found.areas[0].rings.at(0).size() == 5);
}

TEST_CASE("a rule that breaks a limit is refused with what was expected") {
  const auto with = [](const char* key, const nlohmann::json& value) {
    nlohmann::json properties{{"model", "fir"}, {"density", 5}};
    properties[key] = value;
    return refusal(square(properties));
  };
  CHECK(with("seed", 3).empty());
  CHECK(with("density", nullptr) == "density: expected objects per hectare, above 0, found 0");
  CHECK(with("density", 1e6) == "density: expected 0 to 100000, found 1000000");
  CHECK(with("spacing", 100) ==
        "density: expected at most 0.3119 per hectare where the spacing is 100 m, found 5");
  CHECK(with("spacing", -1) == "spacing: expected 0 to 10000, found -1");
  CHECK(with("seed", 1.5) == "seed: expected a whole number of 0 to 2^53, found 1.5");
  CHECK(with("seed", -1) == "seed: expected a whole number of 0 to 2^53, found -1");
  CHECK(with("min_scale", 0) == "min_scale: expected 0.000244140625 to 15.999755859375, found 0");
  CHECK(with("min_scale", 2) == "min_scale: expected at most max_scale, which is 1, found 2");
  CHECK(with("max_slope", 91) == "max_slope: expected 0 to 90, found 91");
  CHECK(with("min_height", "high") == "min_height: expected a number, found \"high\"");
  CHECK(with("max_height", "nan") == "min_height: expected at most max_height, which is nan, found -inf");
  CHECK(with("model", "fir:0") == "model: expected a weight above 0 after the colon, found 'fir:0'");
  CHECK(with("model", "fir,,oak") == "model: expected NAME[:WEIGHT],…, found 'fir,,oak'");
  CHECK(with("model", "") == "model: expected NAME[:WEIGHT],…, found none");
  CHECK(with("heading", 4000) == "heading: expected -3600 to 3600, found 4000");
  nlohmann::json two = square({{"model", "fir"}, {"density", 5}});
  two["geometry"]["coordinates"][0] = {{0, 0}, {1, 1}};
  CHECK(refusal(two) == "coordinates: expected rings of 3 or more places, found 2");
  two["geometry"]["coordinates"][0] = {{500000, 0}, {1, 1}, {2, 0}};
  CHECK(refusal(two) == "lon: expected -360 to 360, found 500000");
}

TEST_CASE("places come out of the store by tile, in one order, whatever part of them is in memory") {
  const TempDir dir;
  std::mt19937 random(4);
  std::vector<StoredPlace> places;
  for (int i = 0; i < 5000; ++i) {
    StoredPlace place;
    const int level = 3 + static_cast<int>(random() % 3);
    place.tile = {level, static_cast<std::int32_t>(random() % 3), static_cast<std::int32_t>(random() % 3)};
    place.object.x = static_cast<std::uint16_t>(random());
    place.object.y = static_cast<std::uint16_t>(random());
    place.object.model = static_cast<std::uint16_t>(random() % 4);
    places.push_back(place);
  }
  std::vector<std::vector<std::pair<TileId, PlacedObject>>> orders;
  for (const std::size_t in_memory : {std::size_t{7}, std::size_t{700}, std::size_t{1000000}}) {
    std::shuffle(places.begin(), places.end(), random);
    PlaceStore store(dir.path(), in_memory);
    for (const StoredPlace& place : places) REQUIRE(store.add(place));
    auto& order = orders.emplace_back();
    int level = 99;
    REQUIRE(store.visit([&](const TileId& id, std::vector<StoredPlace>&& tile) -> Status {
      CHECK(id.level <= level);
      level = id.level;
      for (const StoredPlace& place : tile) {
        CHECK(place.tile == id);
        order.emplace_back(id, place.object);
      }
      return {};
    }));
    CHECK(order.size() == places.size());
  }
  CHECK((orders[0] == orders[1]));
  CHECK((orders[1] == orders[2]));
}

TEST_CASE("a tile with too many objects is one line that names it") {
  const TempDir dir;
  PlaceStore store(dir.path(), std::size_t{1} << 18);
  StoredPlace place;
  place.tile = {5, 1, 2};
  for (std::size_t i = 0; i <= kMostObjects; ++i) REQUIRE(store.add(place));
  const Status status = store.visit([](const TileId&, std::vector<StoredPlace>&&) { return Status(); });
  REQUIRE(!status);
  CHECK(status.error().message ==
        "objects: tile " + to_string(place.tile) + ": expected at most 1048576 objects, found more");
}

}  // namespace cairn::test
