// Objects that are scattered in polygons: as many as the density says, no two nearer than the spacing, and a
// function of the place alone.
#include "builder/objects/scatter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn::test {
namespace {

constexpr GeoBounds kWorld{-180, -90, 180, 90};
constexpr double kRadian = std::numbers::pi / 180;

ScatterRule rule_of(double per_hectare, double spacing_m, std::uint64_t seed = 1) {
  ScatterRule rule;
  rule.models = {{"fir", 3}, {"oak", 1}};
  rule.per_hectare = per_hectare;
  rule.spacing_m = spacing_m;
  rule.seed = seed;
  return rule;
}

std::vector<LonLat> box(double west, double south, double east, double north) {
  return {{west, south}, {east, south}, {east, north}, {west, north}};
}

std::vector<ObjectPlace> scattered(const ScatterArea& area, const GeoBounds& bounds = kWorld,
                                   const Body& body = {}) {
  std::vector<ObjectPlace> places;
  REQUIRE(check_area(area));
  REQUIRE(scatter(area, body, bounds, [&](const ObjectPlace& place) -> Status {
    REQUIRE(check_place(place));
    places.push_back(place);
    return {};
  }));
  return places;
}

using Key = std::tuple<double, double, std::string, double, double>;
std::multiset<Key> keys_of(const std::vector<ObjectPlace>& places, double turn = 0) {
  std::multiset<Key> keys;
  for (const ObjectPlace& p : places)
    keys.emplace(p.at.lon + turn, p.at.lat, p.model, p.heading_degrees, p.scale);
  return keys;
}

/// Great circles on a sphere of the Earth's mean radius: an oracle within 0.6 %.
double metres_between(LonLat a, LonLat b) {
  const double u = std::sin((b.lat - a.lat) * kRadian / 2), v = std::sin((b.lon - a.lon) * kRadian / 2);
  return 2 * 6371008.8 *
         std::asin(std::sqrt(u * u + std::cos(a.lat * kRadian) * std::cos(b.lat * kRadian) * v * v));
}

double nearest_pair_m(const std::vector<ObjectPlace>& places) {
  double nearest = 1e9;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = i + 1; j < places.size(); ++j) {
      if (std::abs(places[i].at.lat - places[j].at.lat) * 110000 < nearest)
        nearest = std::min(nearest, metres_between(places[i].at, places[j].at));
    }
  }
  return nearest;
}

/// On a sphere.
double hectares(double west, double south, double east, double north, double radius_m) {
  return radius_m * radius_m * (east - west) * kRadian *
         (std::sin(north * kRadian) - std::sin(south * kRadian)) / 1e4;
}

}  // namespace

TEST_CASE("as many objects are scattered as the density says, at any latitude, spacing and body") {
  const Body moon = *known_body("Moon");
  for (const auto& [south, width] :
       {std::pair{0.0, 0.05}, {45.0, 0.05}, {-60.0, 0.1}, {88.0, 1.0}, {89.9, 90.0}}) {
    for (const double spacing : {0.0, 10.0, 25.0}) {
      const ScatterArea area{rule_of(4, spacing), {box(10, south, 10 + width, south + 0.05)}};
      const double expected = 4 * hectares(10, south, 10 + width, south + 0.05, moon.shape.semi_major_m);
      const auto count = static_cast<double>(scattered(area, kWorld, moon).size());
      INFO(south << " " << spacing << ": " << count << " of " << expected);
      CHECK(std::abs(count - expected) < 5 * std::sqrt(expected));
    }
  }
}

TEST_CASE("no two scattered objects are nearer than the spacing, also at 180 degrees and at a pole") {
  for (const auto& ring :
       {box(10, 45, 10.03, 45.02), box(179.99, -17, 180.01, -16.98), box(-180, 89.99, 180, 90)}) {
    for (const double spacing : {15.0, 30.0}) {
      const double most = 0.98e4 / (std::numbers::pi * spacing * spacing);
      const auto places = scattered({rule_of(most * 0.9, spacing), {ring}});
      REQUIRE(places.size() > 300);
      const double nearest = nearest_pair_m(places);
      CHECK(nearest > spacing * 0.993);
      CHECK(nearest < spacing * 1.3);
    }
  }
}

TEST_CASE("without a spacing the counts of equal squares scatter as those of a Poisson process") {
  const auto places = scattered({rule_of(5, 0), {box(20, 0, 20.2, 0.2)}});
  std::map<std::pair<int, int>, double> counts;
  for (int x = 0; x < 50; ++x) {
    for (int y = 0; y < 50; ++y) counts[{x, y}] = 0;
  }
  for (const ObjectPlace& p : places)
    ++counts[{static_cast<int>((p.at.lon - 20) * 250), static_cast<int>(p.at.lat * 250)}];
  const double mean = static_cast<double>(places.size()) / 2500;
  double variance = 0;
  for (const auto& [square, count] : counts) variance += (count - mean) * (count - mean) / 2499;
  // The index of dispersion of 2500 squares has a standard deviation of sqrt(2 / 2499) = 0.028.
  CHECK(std::abs(variance / mean - 1) < 5 * 0.028);
}

TEST_CASE("parts of bounds and neighbouring areas give the objects of one, each once") {
  const std::vector<LonLat> ring{{10, 45}, {10.05, 45.01}, {10.04, 45.05}, {10.02, 45.02}, {9.99, 45.04}};
  for (const double spacing : {0.0, 12.0}) {
    const ScatterArea area{rule_of(8, spacing), {ring}};
    const auto whole = keys_of(scattered(area));
    REQUIRE(whole.size() > 500);
    std::multiset<Key> parts;
    for (const GeoBounds& bounds :
         {GeoBounds{9, 44, 10.013, 45.027}, {10.013, 44, 11, 45.027}, {9, 45.027, 11, 46}})
      parts.merge(keys_of(scattered(area, bounds)));
    CHECK((parts == whole));
    // The ring cut along the diagonal from its second to its fourth vertex.
    std::multiset<Key> halves = keys_of(scattered({area.rule, {{ring[1], ring[2], ring[3]}}}));
    halves.merge(keys_of(scattered({area.rule, {{ring[3], ring[4], ring[0], ring[1]}}})));
    CHECK((halves == whole));
  }
}

TEST_CASE("a turn of the area or of the bounds changes nothing but the longitudes") {
  const auto east = scattered({rule_of(8, 12), {box(179.98, 10, 180.02, 10.03)}}, {170, 0, 190, 20});
  const auto west = scattered({rule_of(8, 12), {box(-180.02, 10, -179.98, 10.03)}}, {170, 0, 190, 20});
  REQUIRE(east.size() > 500);
  REQUIRE(west.size() == east.size());
  std::multiset<std::pair<long long, double>> a, b;
  for (const ObjectPlace& p : east) a.emplace(std::llround((p.at.lon - 180) * 1e9), p.at.lat);
  for (const ObjectPlace& p : west) b.emplace(std::llround((p.at.lon + 180) * 1e9), p.at.lat);
  CHECK(a == b);
}

TEST_CASE("holes, second polygons and the seed decide where objects are, weights and ranges what they are") {
  ScatterRule rule = rule_of(20, 0);
  rule.min_scale = 0.5;
  rule.max_scale = 2;
  const auto places = scattered(
      {rule, {box(10, 45, 10.05, 45.05), box(10.01, 45.01, 10.04, 45.04), box(10.02, 45.02, 10.03, 45.03)}});
  std::size_t firs = 0, clockwise = 0, large = 0;
  for (const ObjectPlace& p : places) {
    const double off = std::max(std::abs(p.at.lon - 10.025), std::abs(p.at.lat - 45.025));
    CHECK((off < 0.005 || off > 0.015));
    CHECK(off <= 0.025);
    CHECK((p.scale >= 0.5 && p.scale < 2));
    firs += p.model == "fir" ? 1u : 0u;
    clockwise += p.heading_degrees < 180 ? 1u : 0u;
    large += p.scale > 1.25 ? 1u : 0u;
  }
  const auto n = static_cast<double>(places.size());
  REQUIRE(n > 5000);
  CHECK(std::abs(static_cast<double>(firs) - 0.75 * n) < 5 * std::sqrt(n * 0.1875));
  CHECK(std::abs(static_cast<double>(clockwise) - 0.5 * n) < 5 * std::sqrt(n * 0.25));
  CHECK(std::abs(static_cast<double>(large) - 0.5 * n) < 5 * std::sqrt(n * 0.25));
  CHECK(keys_of(scattered({rule_of(20, 0, 1), {box(10, 45, 10.01, 45.01)}})) !=
        keys_of(scattered({rule_of(20, 0, 2), {box(10, 45, 10.01, 45.01)}})));
}

TEST_CASE("more than a thousand million objects in an area are refused at once") {
  const ScatterArea area{rule_of(1000, 0), {box(-180, -90, 180, 90)}};
  const Status status = scatter(area, {}, kWorld, [](const ObjectPlace&) { return Status(); });
  REQUIRE(!status);
  CHECK(status.error().message.find("density: expected at most 1e+09 objects") != std::string::npos);
}

}  // namespace cairn::test
