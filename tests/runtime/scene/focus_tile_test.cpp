#include "runtime/scene/focus_tile.h"

#include <cmath>
#include <random>
#include <set>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("the finest level's samples are at most a pixel apart, and the next coarser's are more") {
  ViewState view;
  for (double distance = 10; distance < 1e7; distance *= 1.7) {
    for (const int tile_size : {257, 513}) {
      FocusTile eye(0, 0);
      const int level =
          eye.update({10, 50}, level_for_pixel_size(view, distance, tile_size), kMinLevel, kMaxLevel).level;
      const double spacing = 111319.4908 * tile_width_degrees(level) / (tile_size - 1);
      CHECK(spacing <= pixel_footprint_m(view, distance) * 1.000001);
      CHECK(2 * spacing > pixel_footprint_m(view, distance));
    }
  }
}

TEST_CASE("the level stays within those that there are, down to the ground") {
  ViewState view;
  FocusTile eye(0.1, 0.1);
  CHECK(eye.update({0, 0}, level_for_pixel_size(view, 0, 513), -9, 4).level == 4);
  CHECK(eye.update({0, 0}, level_for_pixel_size(view, -50, 513), -9, 4).level == 4);
  CHECK(eye.update({0, 0}, level_for_pixel_size(view, 1e12, 513), -3, 4).level == -3);
}

TEST_CASE("an eye that stays within the margins changes its level once at most and its tile once besides") {
  std::mt19937_64 random(1);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 500; ++i) {
    const double margin = between(0.02, 0.5), level_margin = between(0.02, 0.5);
    const double ideal = between(-5, 12);
    const LonLat corner{between(-180, 180), between(-80, 80)};
    const double box = margin * tile_width_degrees(static_cast<int>(std::ceil(ideal + level_margin)));
    FocusTile eye(margin, level_margin);
    eye.update({between(-180, 180), between(-90, 90)}, between(-5, 12), kMinLevel, kMaxLevel);
    std::optional<TileId> last;
    int changes = 0, level_changes = 0;
    for (int j = 0; j < 200; ++j) {
      const LonLat place{corner.lon + between(0, box), corner.lat + between(0, box)};
      const TileId now = eye.update(place, ideal + between(0, level_margin), kMinLevel, kMaxLevel);
      changes += last && *last != now;
      level_changes += last && last->level != now.level;
      last = now;
    }
    REQUIRE(level_changes <= 1);
    REQUIRE(changes <= 1 + level_changes);
  }
}

TEST_CASE("the eye is never farther outside its tile than the margin") {
  std::mt19937_64 random(2);
  FocusTile eye(0.125, 0.25);
  LonLat place{179.9, 89.5};
  for (int i = 0; i < 20000; ++i) {
    std::uniform_real_distribution<double> step(-0.05, 0.05);
    place = {place.lon + step(random), std::clamp(place.lat + step(random), -90.0, 90.0)};
    const TileId id = eye.update(place, 2.5, kMinLevel, kMaxLevel);
    const GeoBounds b = tile_bounds(id);
    const double out = std::abs(std::remainder(place.lon - (b.west + b.east) / 2, 360)) - b.width() / 2;
    REQUIRE(out <= 0.125 * b.width() + 1e-12);
    REQUIRE(b.south - place.lat <= 0.125 * b.width());
    REQUIRE(place.lat - b.north <= 0.125 * b.width());
  }
}

TEST_CASE("without margins an eye on a border changes its tile every time that it crosses") {
  FocusTile eye(0, 0);
  std::set<TileId> tiles;
  for (int i = 0; i < 10; ++i) tiles.insert(eye.update({28 + (i % 2 ? 1e-6 : -1e-6), 36.5}, 0, -9, 5));
  CHECK(tiles.size() == 2);
}

}  // namespace cairn
