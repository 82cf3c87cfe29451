// Lines on the drawn ground, against the line's places projected one by one.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/pack_sampler.h"
#include "runtime/surface/drape_index.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

struct Found {
  int on_line = 0;  ///< places of the line that the picture shows
  int missing = 0;  ///< of these, without a changed pixel within two
  int changed = 0;  ///< pixels
  int stray = 0;    ///< of these, more than four from the line
};

/// Draws a line 3 pixels wide, and looks where the picture has changed.
Found look_for(Stage& stage, const PackReader& pack, const ViewState& view, const DrapedLine& line) {
  stage.look.drape = nullptr;
  stage.draw(view);
  const gl::Picture without = stage.target().read();
  const std::vector<float> depth = stage.target().read_depth();
  Drape drape;
  drape.lines.push_back(line);
  stage.look.drape = std::make_shared<const Drape>(drape);
  stage.draw(view);
  const gl::Picture with = stage.target().read();
  const auto is_changed = [&](int column, int row) {
    const std::uint8_t *a = with.pixel(column, row), *b = without.pixel(column, row);
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 24;
  };
  std::vector<bool> is_near(kWidth * kHeight, false);
  Found found;
  PackSampler sampler(pack, 64);
  for (std::size_t i = 0; i + 1 < line.places.size(); ++i) {
    const LonLat from = line.places[i];
    const double lon = std::remainder(line.places[i + 1].lon - from.lon, 360.0),
                 lat = line.places[i + 1].lat - from.lat;
    constexpr int kSteps = 3000;
    for (int step = 0; step <= kSteps; ++step) {
      const LonLat at{from.lon + lon * step / kSteps, from.lat + lat * step / kSteps};
      const auto height = sampler.height_at(at);
      REQUIRE(height.ok());
      if (!*height) continue;
      const PicturePoint p = project(view, to_geocentric(at, (*height)->metres));
      const int column = static_cast<int>(std::floor(p.x)), row = static_cast<int>(std::floor(p.y));
      if (p.depth_m <= 0 || column < 4 || row < 4 || column >= kWidth - 4 || row >= kHeight - 4) continue;
      bool is_seen = true, has_change = false;
      for (int dy = -4; dy <= 4; ++dy) {
        for (int dx = -4; dx <= 4; ++dx) {
          if (dx * dx + dy * dy <= 16)
            is_near[static_cast<std::size_t>((row + dy) * kWidth + column + dx)] = true;
          if (std::max(std::abs(dx), std::abs(dy)) > 2) continue;
          has_change = has_change || is_changed(column + dx, row + dy);
          // Nothing nearer around it, so that it is seen for certain.
          const double shown_m =
              gl::kNear_m /
              static_cast<double>(depth[static_cast<std::size_t>((row + dy) * kWidth + column + dx)]);
          is_seen = is_seen && shown_m > 0.97 * p.depth_m;
        }
      }
      if (!is_seen) continue;
      ++found.on_line;
      found.missing += !has_change;
    }
  }
  for (int row = 4; row < kHeight - 4; ++row) {
    for (int column = 4; column < kWidth - 4; ++column) {
      if (!is_changed(column, row)) continue;
      ++found.changed;
      found.stray += !is_near[static_cast<std::size_t>(row * kWidth + column)];
    }
  }
  return found;
}

}  // namespace

TEST_CASE("a draped line lies on the drawn ground, from any height, at the antimeridian, too") {
  for (const std::size_t place : {std::size_t{0}, std::size_t{1}}) {
    const TempDir dir;
    write_ridge_pack(dir.path() / "a.cairn", place, place);
    const auto pack = PackReader::open(dir.path() / "a.cairn");
    REQUIRE(pack.ok());
    Stage stage(dir.path() / "a.cairn", kWidth, kHeight);
    stage.look.fog = false;
    const LonLat eye = ridge_places()[place];
    stage.look.to_sun = sun_at(eye, 200, 50);
    struct Shot {
      double height_m, pitch_deg, reach_deg;
    };
    for (const Shot& shot : {Shot{2600, -35, 0.03}, {6000, -50, 0.06}, {60000, -60, 0.5}, {2e6, -80, 12}}) {
      const double r = shot.reach_deg;
      const DrapedLine line{{{eye.lon - r, eye.lat + 0.2 * r},
                             {eye.lon + 0.3 * r, eye.lat + 0.5 * r},
                             {std::remainder(eye.lon + r, 360.0), eye.lat + 0.9 * r}},
                            {1, 0, 0},
                            3};
      const Found found = look_for(stage, *pack, view_at(eye, shot.height_m, 10, shot.pitch_deg), line);
      CAPTURE(place, shot.height_m, found.on_line, found.changed);
      CHECK(found.on_line > 300);
      CHECK(found.changed > 100);
      CHECK(found.missing == 0);
      // On ground that is seen edge-on, how the place changes from pixel to pixel says little of the ground
      // beside it.
      CHECK(found.stray <= found.changed / 40);
    }
  }
}

TEST_CASE(
    "the pieces of a line in a patch are those that cross it, and far ones are left out where they are "
    "small") {
  std::mt19937 random(3);
  std::normal_distribution<double> step(0, 0.002);
  DrapedLine walk{{{179.9, 10.0}}, {1, 1, 1}, 3};
  for (int i = 0; i < 50000; ++i) {
    walk.places.push_back({std::remainder(walk.places.back().lon + step(random), 360.0),
                           walk.places.back().lat + step(random)});
  }
  Drape drape;
  drape.lines.push_back(walk);
  drape.lines.push_back({{{20, -30}}, {1, 1, 1}, 9});  // a point
  DrapeIndex index(std::make_shared<const Drape>(drape));
  for (const int level : {-9, -3, 0, 3, 6}) {
    int cells = 0;
    for (std::size_t i = 0; i < walk.places.size(); i += 5000) {
      const TileId patch = tile_at(walk.places[i], level);
      const GeoBounds b = tile_bounds(patch);
      const glm::vec2 at(
          (std::remainder(walk.places[i].lon - b.west - b.width() / 2, 360.0) + b.width() / 2) / b.width(),
          (walk.places[i].lat - b.south) / b.height());
      float nearest = 10;
      for (const DrapedSegment& piece : index.in(patch, 1e-5)) {
        const glm::vec2 from(piece.ends), to(piece.ends.z, piece.ends.w), along = to - from;
        const float share =
            glm::clamp(glm::dot(at - from, along) / std::max(glm::dot(along, along), 1e-20f), 0.0f, 1.0f);
        nearest = std::min(nearest, glm::distance(at, from + share * along));
        CHECK(std::max(std::abs(from.x - 0.5f), std::abs(from.y - 0.5f)) < 0.751f);
      }
      CHECK(nearest < 2e-5f);
      ++cells;
    }
    CHECK(cells == 11);
  }
  // Fifty thousand places, seen where a hundredth of the patch is no pixel.
  CHECK(index.in(tile_at(walk.places[0], -9), 0.01).size() < 200);
  CHECK(index.in(tile_at({20, -30}, 4), 0.01).size() == 1);
  CHECK(index.in(tile_at({60, -30}, 4), 0.01).empty());
}

}  // namespace cairn::test
