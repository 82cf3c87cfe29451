// Shadows of the ground in pictures, against rays to the sun through the pack's finest ground.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/ground_query.h"
#include "runtime/light/tile_shadow.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kSunRadius_deg = 0.267;

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }

 private:
  std::mt19937 random_;
};

std::shared_ptr<const PackReader> reader_of(const std::filesystem::path& path) {
  Result<PackReader> reader = PackReader::open(path);
  REQUIRE(reader.ok());
  return std::make_shared<const PackReader>(std::move(*reader));
}

enum class Seen { all, none, part };

/// How much of the sun's disc is seen from a place on the ground.
class Oracle {
 public:
  explicit Oracle(const std::filesystem::path& pack) : query_(reader_of(pack), 256) {}

  /// nullopt where there is no ground.
  std::optional<GroundHit> ground(LonLat place) {
    const auto hit = query_.ray(to_geocentric(place, 9500), -local_frame(place).up, 20000);
    REQUIRE(hit.ok());
    return *hit;
  }
  Seen sun(const GroundHit& at, const glm::dvec3& to_sun) {
    const glm::dvec3 up = local_frame(at.at.place).up;
    const double height = std::asin(glm::dot(up, to_sun));
    const glm::dvec3 level = glm::normalize(to_sun - up * std::sin(height));
    const auto is_hidden = [&](double above_deg) {
      const double h = height + glm::radians(above_deg);
      const auto hit = query_.ray(at.point + up * 0.05, level * std::cos(h) + up * std::sin(h), 4e5);
      REQUIRE(hit.ok());
      return hit->has_value();
    };
    if (is_hidden(kSunRadius_deg)) return Seen::none;
    return is_hidden(-kSunRadius_deg) ? Seen::part : Seen::all;
  }

 private:
  GroundQuery query_;
};

struct Tally {
  int lit = 0;
  int dark = 0;
  int wrong_lit = 0;   // of the lit, shown in shadow
  int wrong_dark = 0;  // of the dark, shown lit
};

/// Compares random pixels of a picture with the rays; those whose surroundings are not all as they are make
/// the rim, and are left out.
class ShadowCheck {
 public:
  ShadowCheck(const std::filesystem::path& pack, double cell_m)
      : stage_(pack, kWidth, kHeight), oracle_(pack), cell_m_(cell_m) {
    stage_.look.fog = false;
    stage_.look.waits_for_shadows = true;
  }

  void view(ViewState view, double above_m, double azimuth_deg, double height_deg, Dice& dice, Tally& tally) {
    view.viewport_width_px = kWidth;
    view.viewport_height_px = kHeight;
    for (int lift = 0; lift < 2; ++lift) {
      stage_.scene().load_all(view);
      view.height_m = above_m + stage_.ground_m(view.eye);
    }
    const glm::dvec3 to_sun = sun_at(view.eye, azimuth_deg, height_deg);
    stage_.look.to_sun = to_sun;
    stage_.look.shadows = false;
    stage_.draw(view);
    const gl::Picture bright = stage_.target().read();
    const std::vector<float> depth = stage_.target().read_depth();
    stage_.look.shadows = true;
    stage_.draw(view);
    const gl::Picture shaded = stage_.target().read();
    for (int i = 0; i < 40; ++i) {
      const int column = static_cast<int>(dice.between(0, kWidth)),
                row = static_cast<int>(dice.between(0, kHeight));
      const auto at = static_cast<double>(depth[static_cast<std::size_t>(row * kWidth + column)]);
      if (at <= 0) continue;
      const glm::dvec3 point = shown_at(view, column + 0.5, row + 0.5, at);
      const double pixel_m = pixel_footprint_m(view, glm::distance(point, camera_frame(view).position));
      const auto seen = surroundings(to_geodetic(point).place, to_sun, 2 * std::max(pixel_m, cell_m_));
      if (!seen) continue;
      int darker = 0;
      for (int c = 0; c < 3; ++c) darker += bright.pixel(column, row)[c] - shaded.pixel(column, row)[c];
      if (*seen == Seen::all) {
        ++tally.lit;
        tally.wrong_lit += darker > 3;
      } else {
        ++tally.dark;
        tally.wrong_dark += darker < 6;
      }
    }
  }

 private:
  /// What all places around see of the sun, if they agree and the slopes are such that a shadow can be told.
  std::optional<Seen> surroundings(LonLat place, const glm::dvec3& to_sun, double rim_m) {
    const double lat = rim_m / 111000, lon = lat / std::max(std::cos(glm::radians(place.lat)), 0.01);
    std::optional<Seen> all;
    for (int part = 0; part < 9; ++part) {
      const auto hit = oracle_.ground({place.lon + (part % 3 - 1) * lon, place.lat + (part / 3 - 1) * lat});
      if (!hit) return std::nullopt;
      const double slope = glm::dot(hit->normal, to_sun);
      const Seen seen = oracle_.sun(*hit, to_sun);
      if (seen == Seen::part || (all && seen != *all)) return std::nullopt;
      // Ground that faces away has no light to lose.
      if (seen == Seen::none && slope < 0.15) return std::nullopt;
      all = seen;
    }
    return all;
  }

  Stage stage_;
  Oracle oracle_;
  double cell_m_;
};

void check(const std::filesystem::path& pack, const GeoBounds& bounds, double cell_m, int views,
           unsigned seed) {
  ShadowCheck check(pack, cell_m);
  Dice dice(seed);
  Tally tally;
  for (int i = 0; i < views; ++i) {
    const LonLat eye{dice.between(bounds.west, bounds.east), dice.between(bounds.south, bounds.north)};
    const double above = dice.log_between(300, 20000), azimuth = dice.between(0, 360),
                 height = dice.log_between(2, 60);
    check.view(view_at(eye, above, dice.between(0, 360), dice.between(-85, -25)), above, azimuth, height,
               dice, tally);
  }
  WARN(views << " views: of " << tally.lit << " lit places " << tally.wrong_lit << " are in shadow, of "
             << tally.dark << " dark ones " << tally.wrong_dark << " are lit");
  CHECK(tally.lit > views);
  CHECK(tally.dark > views / 4);
  CHECK(tally.wrong_lit == 0);
  CHECK(tally.wrong_dark == 0);
}

}  // namespace

TEST_CASE("a pixel is in shadow where rays to the sun meet the finest ground, in 200 views") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  SECTION("the Alps, with voids") {
    if (!bake_real_pack(pack, {"geotiff/N46E008.tif"})) return;
    check(pack, {8.1, 46.1, 8.9, 46.9}, 92, 100, 2);
  }
  SECTION("generated ridges") {
    write_ridge_pack(pack, 0, 0);
    const LonLat place = ridge_places()[0];
    check(pack, {place.lon - 0.04, place.lat - 0.04, place.lon + 0.04, place.lat + 0.04}, 28, 100, 3);
  }
}

TEST_CASE("a tile's shadow is that of rays, at the antimeridian and near the poles, too") {
  const TempDir dir;
  for (std::size_t i = 0; i < 5; ++i) {
    const auto path = dir.path() / (std::to_string(i) + ".cairn");
    write_ridge_pack(path, i, i);
    const auto pack = reader_of(path);
    ShadowGround ground(pack);
    Oracle oracle(path);
    Dice dice(static_cast<unsigned>(i));
    const TileId id = tile_at(ridge_places()[i], kRidgesFinest);
    const auto entry = pack->find(Layer::heights, id);
    REQUIRE(entry);
    const Result<HeightTile> heights = pack->read_height_tile(*entry);
    REQUIRE(heights.ok());
    const GeoBounds b = tile_bounds(id);
    const LonLat middle{b.west + b.width() / 2, b.south + b.height() / 2};
    int lit = 0, dark = 0, wrong = 0;
    for (int suns = 0; suns < 3; ++suns) {
      const glm::dvec3 to_sun = sun_at(middle, dice.between(0, 360), dice.log_between(3, 40));
      const std::vector<std::int8_t> texels = tile_shadow(ground, id, *heights, to_sun);
      // Rays near a pole pass a column each few centimetres.
      const int samples = std::abs(middle.lat) > 89 ? 12 : 150;
      for (int sample = 0; sample < samples; ++sample) {
        const int column = static_cast<int>(dice.between(2, heights->size - 2)),
                  row = static_cast<int>(dice.between(2, heights->size - 2));
        const int texel = texels[static_cast<std::size_t>(row * heights->size + column)];
        // 0.3 degrees: a cell of these ridges is as steep as 70.
        if (std::abs(texel) * kShadowRange_deg / 127 < 0.3 + kSunRadius_deg) continue;
        const double cell = b.width() / (heights->size - 1);
        const LonLat place{b.west + column * cell, b.south + row * cell};
        const double height_m = heights->at(column, row) * pack->header().quantum_m;
        const GroundHit at{{place, height_m}, to_geocentric(place, height_m), {}, 0, 0, 0};
        const Seen seen = oracle.sun(at, to_sun);
        if (seen == Seen::part) continue;
        lit += texel < 0;
        dark += texel > 0;
        wrong += (texel > 0) != (seen == Seen::none);
      }
    }
    CAPTURE(i, lit, dark);
    WARN("tile " << i << ": " << lit << " lit, " << dark << " dark, " << wrong << " wrong");
    CHECK(lit + dark > 10);
    CHECK(wrong <= 1 + (lit + dark) / 100);
  }
}

TEST_CASE("gentle ground of a wide tile is lit where the sun is high, also around its zenith") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  const auto pack = reader_of(dir.path() / "a.cairn");
  ShadowGround ground(pack);
  const TileId id = tile_at(ridge_places()[0], -6);
  const auto entry = pack->find(Layer::heights, id);
  REQUIRE(entry);
  const Result<HeightTile> heights = pack->read_height_tile(*entry);
  REQUIRE(heights.ok());
  const GeoBounds b = tile_bounds(id);
  Dice dice(9);
  for (int suns = 0; suns < 12; ++suns) {
    const LonLat zenith{dice.between(b.west, b.east), dice.between(b.south, std::min(b.north, 80.0))};
    const glm::dvec3 to_sun = local_frame(zenith).up;
    const std::vector<std::int8_t> texels = tile_shadow(ground, id, *heights, to_sun);
    int high = 0, dark = 0;
    for (int row = 0; row < heights->size; ++row) {
      for (int column = 0; column < heights->size; ++column) {
        const double cell = b.width() / (heights->size - 1);
        const LonLat place{b.west + column * cell, b.south + row * cell};
        // Slopes between these samples, 28 km apart, are less than 10 degrees.
        if (place.lat > 80 || glm::dot(local_frame(place).up, to_sun) < std::cos(glm::radians(60.0)))
          continue;
        ++high;
        dark += texels[static_cast<std::size_t>(row * heights->size + column)] >= 0;
      }
    }
    CAPTURE(zenith.lon, zenith.lat, high);
    CHECK(high > 1000);
    CHECK(dark == 0);
  }
}

}  // namespace cairn::test
