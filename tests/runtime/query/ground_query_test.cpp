// Rays and lines of sight against a march in small steps over PackSampler, which shares no code with them.

#include "cairn/ground_query.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/pack_sampler.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr float kFinestError_m = 0.5F;

/// Hills of 600 to 1,400 m around a place: level 2 with samples 108 m apart, one tile of level 1 only, and a
/// void of some cells.
class HillPack {
 public:
  explicit HillPack(LonLat place) : place_(place) {
    const test::TestSurface surface{257, 2, test::hills, [this](std::int64_t column, std::int64_t row) {
                                      const std::int64_t x = column - column_, y = row - row_;
                                      return x >= 300 && x < 320 && y >= 300 && y < 330;
                                    }};
    const TileId middle = tile_at(place, 2);
    column_ = std::int64_t{middle.x - 1} * 256;
    row_ = std::int64_t{middle.y - 1} * 256;
    std::vector<TileId> tiles;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const TileId id = neighbour_of(middle, dx, dy);
        if (is_valid(id)) tiles.push_back(dx == 1 && dy == 1 ? parent_of(id) : id);
      }
    }
    test::write_test_pack(dir_.path() / "hills.cairn", surface, test::with_ancestors(tiles, 0),
                          [](IndexEntry& entry, HeightTile&) {
                            entry.geometric_error_m = entry.id.level == 2 ? kFinestError_m : 900;
                          });
    Result<PackReader> opened = PackReader::open(dir_.path() / "hills.cairn");
    REQUIRE(opened.ok());
    pack = std::make_shared<const PackReader>(std::move(*opened));
  }

  std::shared_ptr<const PackReader> pack;

 private:
  test::TempDir dir_;
  LonLat place_;
  std::int64_t column_ = 0;
  std::int64_t row_ = 0;
};

/// The height of a point above the sampler's ground; infinite where there is none.
double above_m(PackSampler& sampler, const glm::dvec3& point) {
  const Geodetic at = to_geodetic(point);
  const auto ground = sampler.height_at(at.place);
  REQUIRE(ground.ok());
  return *ground ? at.height_m - (*ground)->metres : kInfinite;
}

struct March {
  double first_m = kInfinite;  ///< the first step at which the line is not above the ground
  double least_m = kInfinite;  ///< above the ground, of all steps
};
March march(PackSampler& sampler, const glm::dvec3& origin, const glm::dvec3& direction, double length_m,
            double step_m) {
  March found;
  const auto steps = static_cast<int>(std::ceil(length_m / step_m));
  for (int i = 0; i <= steps; ++i) {
    const double t_m = std::min(i * step_m, length_m);
    const double above = above_m(sampler, origin + direction * t_m);
    found.least_m = std::min(found.least_m, above);
    if (above <= 0 && found.first_m == kInfinite) found.first_m = t_m;
  }
  return found;
}

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  std::mt19937_64 random_;
};

Geodetic near(LonLat place, double degrees, double low_m, double high_m, Dice& dice) {
  const double narrowing = std::max(std::cos(place.lat * 3.14159265 / 180), 0.4);
  return {{place.lon + dice.between(-degrees, degrees) / narrowing,
           std::min(place.lat + dice.between(-degrees, degrees), 90.0)},
          dice.between(low_m, high_m)};
}

const std::vector<LonLat> kPlaces{{28.4, 36.6}, {179.9, -16.4}, {20.1, 89.6}};

}  // namespace

TEST_CASE("a ray meets the ground where a march in small steps finds it first") {
  for (const LonLat& place : kPlaces) {
    const HillPack hills(place);
    GroundQuery query(hills.pack);
    PackSampler sampler(*hills.pack, 32);
    Dice dice(7);
    int met = 0, began = 0;
    for (int i = 0; i < 60; ++i) {
      const Geodetic from = near(place, 0.2, 1100, 2500, dice), to = near(place, 0.2, 300, 1500, dice);
      const glm::dvec3 origin = to_geocentric(from.place, from.height_m);
      const glm::dvec3 way = to_geocentric(to.place, to.height_m) - origin;
      const double length_m = glm::length(way);
      const March oracle = march(sampler, origin, way / length_m, length_m, 4);
      const auto hit = query.ray(origin, way * 3.0, length_m);
      REQUIRE(hit.ok());
      CAPTURE(place.lat, i, oracle.first_m, oracle.least_m, length_m);
      if (!*hit) {
        REQUIRE(oracle.first_m == kInfinite);
        continue;
      }
      ++met;
      const double at_m = (*hit)->distance_m;
      CAPTURE(at_m);
      REQUIRE(at_m <= oracle.first_m + 1e-6);
      // It may be earlier than the march's, between two steps. It is on the ground, unless the ground begins
      // there.
      const bool begins = above_m(sampler, origin + way / length_m * (at_m - 0.01)) == kInfinite;
      REQUIRE(std::abs(above_m(sampler, (*hit)->point)) < (at_m == 0 || begins ? kInfinite : 1e-3));
      began += begins ? 1 : 0;
      REQUIRE(glm::length((*hit)->point - (origin + way / length_m * at_m)) < 1e-6);
      REQUIRE((*hit)->error_m == ((*hit)->level == 2 ? Approx(kFinestError_m) : Approx(900)));
    }
    CHECK(met > 20);
    CHECK(began < met / 2);
  }
}

TEST_CASE("rays that pass within metres of a pole meet the ground where a march finds it first") {
  for (const double lat : {89.9995, -89.9995}) {
    const HillPack hills({20.1, lat});
    GroundQuery query(hills.pack);
    PackSampler sampler(*hills.pack, 64);
    Dice dice(11);
    int met = 0, over_pole = 0;
    for (int i = 0; i < 40; ++i) {
      // Across the pole or beside it, a few hundredths of a degree to both sides.
      const double lon = dice.between(19.9, 20.3), side = std::copysign(1, lat);
      const Geodetic from{{lon, side * (90 - dice.between(0.001, 0.03))}, dice.between(1100, 1600)};
      const Geodetic to{
          {lon + (i % 2 == 0 ? 180 : dice.between(-0.3, 0.3)), side * (90 - dice.between(1e-6, 0.002))},
          dice.between(100, 900)};
      const glm::dvec3 origin = to_geocentric(from.place, from.height_m);
      const glm::dvec3 way = to_geocentric(to.place, to.height_m) - origin;
      const double length_m = glm::length(way);
      const March oracle = march(sampler, origin, way / length_m, length_m, 1);
      const auto hit = query.ray(origin, way, length_m);
      REQUIRE(hit.ok());
      CAPTURE(lat, i, oracle.first_m, oracle.least_m, length_m);
      if (!*hit) {
        CHECK(oracle.first_m == kInfinite);
        continue;
      }
      ++met;
      over_pole += i % 2 == 0 ? 1 : 0;
      CHECK((*hit)->distance_m <= oracle.first_m + 1e-6);
      const bool begins =
          above_m(sampler, origin + way / length_m * ((*hit)->distance_m - 0.01)) == kInfinite;
      CHECK(std::abs(above_m(sampler, (*hit)->point)) <
            ((*hit)->distance_m == 0 || begins ? kInfinite : 1e-3));
    }
    CHECK(met > 8);
    CHECK(over_pole > 2);
  }
}

TEST_CASE("a line of sight is clear by what a march finds, and says how sure that is") {
  int clear = 0, blocked = 0;
  for (const LonLat& place : kPlaces) {
    const HillPack hills(place);
    GroundQuery query(hills.pack);
    PackSampler sampler(*hills.pack, 32);
    Dice dice(8);
    for (int i = 0; i < 40; ++i) {
      const Geodetic from = near(place, 0.1, 1200, 1700, dice), to = near(place, 0.1, 1000, 1700, dice);
      const glm::dvec3 origin = to_geocentric(from.place, from.height_m);
      const glm::dvec3 way = to_geocentric(to.place, to.height_m) - origin;
      const double length_m = glm::length(way);
      const March oracle = march(sampler, origin, way / length_m, length_m, 2);
      const auto sight = query.line_of_sight(from, to);
      REQUIRE(sight.ok());
      CAPTURE(place.lat, i, oracle.least_m, sight->clearance_m, sight->error_m);
      REQUIRE(sight->clearance_m <= oracle.least_m + 1e-6);
      // The lines fall and rise by 0.3 m and less in a step of the march, and the ground by as much.
      if (oracle.least_m < kInfinite) REQUIRE(sight->clearance_m > oracle.least_m - 1.5);
      REQUIRE(sight->is_clear == (sight->clearance_m > 0));
      REQUIRE(sight->is_clear == !sight->obstacle.has_value());
      REQUIRE(sight->error_m >= 0);
      REQUIRE(sight->error_m <= 900);
      ++(sight->is_clear ? clear : blocked);
    }
  }
  CHECK(clear > 10);
  CHECK(blocked > 2);
}

TEST_CASE("a line of sight over one tile has the error of that tile, and is certain beyond it") {
  const HillPack hills({28.4, 36.6});
  GroundQuery query(hills.pack);
  PackSampler sampler(*hills.pack);
  const LonLat a{28.38, 36.6}, b{28.42, 36.6};
  const auto sight_at = [&](double height_m) { return *query.line_of_sight({a, height_m}, {b, height_m}); };
  const double grazing_m = 2000 - sight_at(2000).clearance_m;
  for (const double off_m : {-2.0, -0.6, -0.4, 0.4, 0.6, 2.0}) {
    const SightLine sight = sight_at(grazing_m + off_m);
    CHECK(sight.clearance_m == Approx(off_m).margin(1e-4));
    CHECK(sight.error_m == Approx(kFinestError_m).margin(1e-4));
    CHECK(sight.is_clear == (off_m > 0));
    CHECK(sight.is_certain() == (std::abs(off_m) > 0.5));
  }
}

TEST_CASE("the normal is that of the sampler's surface, by differences in space") {
  const HillPack hills({28.4, 36.6});
  GroundQuery query(hills.pack);
  PackSampler sampler(*hills.pack);
  Dice dice(9);
  const auto point = [&](LonLat place) { return to_geocentric(place, (*sampler.height_at(place))->metres); };
  for (int i = 0; i < 200; ++i) {
    const LonLat at{dice.between(28.33, 28.49), dice.between(36.52, 36.7)};
    const auto normal = query.normal(at);
    REQUIRE(normal.ok());
    REQUIRE(normal->has_value());
    constexpr double kStep = 1e-8;  // degrees: within the cell, but for one place in ten thousand
    const glm::dvec3 east = point({at.lon + kStep, at.lat}) - point(at);
    const glm::dvec3 north = point({at.lon, at.lat + kStep}) - point(at);
    const glm::dvec3 expected = glm::normalize(glm::cross(east, north));
    CHECK(glm::dot(**normal, expected) > 1 - 1e-9);
    CHECK(glm::length(**normal) == Approx(1));
  }
}

TEST_CASE("rays pass where there is no ground, and begin under it") {
  const HillPack hills({28.4, 36.6});
  GroundQuery query(hills.pack);
  const auto down_at = [&](LonLat place, double height_m) {
    const LocalFrame frame = local_frame(place);
    const auto hit = query.ray(to_geocentric(place, height_m), -frame.up, 1e5);
    REQUIRE(hit.ok());
    return *hit;
  };
  CHECK_FALSE(down_at({120, 5}, 5000));
  const TileId middle = tile_at({28.4, 36.6}, 2);
  const GeoBounds south_west = tile_bounds(neighbour_of(middle, -1, -1));
  const double cell = 0.25 / 256;
  CHECK_FALSE(down_at({south_west.west + 310 * cell, south_west.south + 315 * cell}, 5000));
  const auto hit = down_at({28.4, 36.6}, 5000);
  REQUIRE(hit);
  PackSampler sampler(*hills.pack);
  CHECK(hit->at.height_m == Approx((*sampler.height_at({28.4, 36.6}))->metres).margin(1e-5));
  CHECK(hit->distance_m == Approx(5000 - hit->at.height_m).margin(1e-5));
  CHECK(down_at({28.4, 36.6}, 100)->distance_m == 0);
}

TEST_CASE("arguments that are no numbers are refused, and a tile that cannot be read is an error") {
  const HillPack hills({28.4, 36.6});
  GroundQuery query(hills.pack);
  const glm::dvec3 origin = to_geocentric({28.4, 36.6}, 3000), up{0, 0, 1};
  const auto refused = [](const auto& result) { return !result && result.error().code == ErrorCode::usage; };
  CHECK(refused(query.ray({NAN, 0, 0}, up)));
  CHECK(refused(query.ray(origin, {0, 0, 0})));
  CHECK(refused(query.ray(origin, {kInfinite, 0, 0})));
  CHECK(refused(query.ray(origin, up, NAN)));
  CHECK(refused(query.ray(origin, up, -1)));
  CHECK(refused(query.line_of_sight({{NAN, 0}, 0}, {{0, 0}, 0})));
  CHECK(refused(query.line_of_sight({{0, 0}, 0}, {{0, 91}, 0})));
  CHECK(refused(query.normal({0, -95})));

  const auto bytes = test::read_bytes(hills.pack->path());
  auto damaged = bytes;
  const IndexEntry entry = *hills.pack->find(Layer::heights, tile_at({28.4, 36.6}, 2));
  damaged[entry.offset + entry.bytes / 2] ^= std::byte{4};
  test::write_bytes(hills.pack->path(), damaged);
  GroundQuery fresh(hills.pack);
  const auto hit = fresh.ray(origin, -local_frame({28.4, 36.6}).up);
  REQUIRE_FALSE(hit.ok());
  CHECK(hit.error().code == ErrorCode::bad_data);
}

}  // namespace cairn
