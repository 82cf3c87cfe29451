// Thousands of rectangles around the Earth, looked up by cell, against a look at each of them.

#include "builder/raster/footprint.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

bool overlap(const GeoBounds& a, const GeoBounds& b, double margin) {
  for (const double turn : {-360.0, 0.0, 360.0})
    if (b.west + turn - margin < a.east - 1e-9 && a.west + 1e-9 < b.east + turn + margin &&
        b.south - margin < a.north - 1e-9 && a.south + 1e-9 < b.north + margin)
      return true;
  return false;
}

struct Sample {
  std::vector<GeoBounds> rectangles;
  Footprint footprint;
};

Sample random_sample(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> lon(-180, 190), lat(-90, 85), size(0.01, 3);
  Sample sample;
  for (int i = 0; i < count; ++i) {
    GeoBounds r{lon(random), lat(random), 0, 0};
    if (i % 3 == 0) r.west = std::floor(r.west), r.south = std::floor(r.south);
    r.east = r.west + (i % 50 == 0 ? 200 : i % 3 == 0 ? 1 : size(random));
    r.north = std::min(90.0, r.south + (i % 3 == 0 ? 1 : size(random)));
    sample.rectangles.push_back(r);
    sample.footprint.add(r);
  }
  return sample;
}

}  // namespace

TEST_CASE("a footprint of many rectangles answers as a look at each of them would") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> lon(-200, 200), lat(-90, 90), size(0.001, 4);
  for (const int count : {1, 3, 70, 3000}) {
    const Sample sample = random_sample(random, count);
    for (int i = 0; i < 500; ++i) {
      GeoBounds area{lon(random), lat(random), 0, 0};
      if (i % 4 == 0) area.west = std::floor(area.west), area.south = std::floor(area.south);
      const double side = i % 4 == 0 ? 1 : size(random);
      area.east = area.west + side;
      area.north = area.south + side;
      const double margin = i % 2 == 0 ? 0 : 0.3;
      const auto hits = [&](const GeoBounds& r) { return overlap(r, area, margin); };
      const bool expected = std::any_of(sample.rectangles.begin(), sample.rectangles.end(), hits);
      CHECK(sample.footprint.overlaps(area, margin) == expected);

      const Footprint near = sample.footprint.near(area, margin);
      for (const GeoBounds& r : sample.rectangles) {
        const bool held =
            std::any_of(near.rectangles().begin(), near.rectangles().end(), [&](const GeoBounds& n) {
              return n.west == r.west && n.south == r.south && n.east == r.east && n.north == r.north;
            });
        if (hits(r)) CHECK(held);
      }
      const LonLat place{area.west, area.south};
      const LonLat nearest = sample.footprint.nearest_to(place);
      const double distance = std::max(std::abs(nearest.lon - place.lon), std::abs(nearest.lat - place.lat));
      CHECK(distance == Approx(sample.footprint.distance_to(place)).margin(1e-9));
      const double within = std::min(sample.footprint.distance_to(nearest), 1.0);
      CHECK(within == Approx(0).margin(1e-9));
    }
  }
}

TEST_CASE("a place on a rectangle's edge, or a turn around the Earth away, is in it") {
  Footprint footprint;
  footprint.add({170, 10, 180, 20});
  CHECK(footprint.distance_to({-190, 15}) == 0);
  CHECK(footprint.distance_to({180, 20}) == 0);
  CHECK(footprint.nearest_to({-179, 25}).lon == Approx(-180));
  CHECK(footprint.nearest_to({-179, 25}).lat == 20);
}

}  // namespace cairn
