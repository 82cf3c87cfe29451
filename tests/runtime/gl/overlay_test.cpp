// Contours, sea and slope colours, pixel by pixel, against the pack's own heights at the places that the
// pixels show.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/ground_query.h"
#include "cairn/pack_sampler.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 240, kHeight = 180;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double linear(std::uint8_t byte) {
  const double c = byte / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// Dunes of 100 to 1,900 m, their slopes from 0 to 50 degrees: quanta at the samples of level kRidgesFinest.
std::int32_t dunes(std::int64_t column, std::int64_t row) {
  const auto x = static_cast<double>(column), y = static_cast<double>(row);
  return static_cast<std::int32_t>(std::lround(4 * (1000 + 900 * std::sin(x / 40) * std::sin(y / 90))));
}

void write_dunes(const std::filesystem::path& path, std::size_t place) {
  write_test_pack(
      path, {257, kRidgesFinest, dunes, {}}, ridge_tiles(place, place), [](IndexEntry& entry, HeightTile&) {
        // What straight lines miss of a sine: a step squared times the curvature, an eighth of it.
        const double error_m = std::min(std::ldexp(0.15, 2 * (kRidgesFinest - entry.id.level)), 1800.0);
        entry.geometric_error_m = entry.id.level < kRidgesFinest ? static_cast<float>(error_m) : 0;
      });
}

/// One view, drawn with and without what is checked.
class Overlay {
 public:
  explicit Overlay(std::size_t place) : place_(ridge_places()[place]) {
    write_dunes(dir_.path() / "a.cairn", place);
    stage_.emplace(dir_.path() / "a.cairn", kWidth, kHeight);
    Result<PackReader> opened = PackReader::open(dir_.path() / "a.cairn");
    REQUIRE(opened.ok());
    pack = std::make_shared<const PackReader>(std::move(*opened));
    look().fog = false;
    look().to_sun = sun_at(place_, 200, 55);
    look().tint = {{0, glm::vec3(0.4f)}, {9000, glm::vec3(0.4f)}};
  }

  viewer::FrameLook& look() { return stage_->look; }

  /// Draws, and takes the places and heights that the pixels show.
  gl::Picture draw(double height_m, double heading_deg, double pitch_deg) {
    view = view_at(place_, height_m, heading_deg, pitch_deg);
    view.viewport_width_px = kWidth;
    view.viewport_height_px = kHeight;
    stage_->draw(view);
    if (places.empty()) look_up();
    return stage_->target().read();
  }

  static std::size_t index(int column, int row) { return static_cast<std::size_t>(row * kWidth + column); }

  /// Metres by which the height changes from a pixel to the next, both ways added: the less and the more of
  /// what the pixels on either side say; NaN at a crest, where the next pixel shows other ground.
  struct Step {
    double least_m = 0;
    double most_m = 0;
  };
  Step height_step(int column, int row) const {
    Step step;
    for (const auto& [dx, dy] : {std::pair(1, 0), {0, 1}}) {
      const double here = heights[index(column, row)];
      const double a = std::abs(heights[index(column + dx, row + dy)] - here),
                   b = std::abs(heights[index(column - dx, row - dy)] - here);
      if (!(std::max(a, b) < 3 * std::min(a, b) + 3)) return {kNone, kNone};
      step.least_m += std::min(a, b);
      step.most_m += std::max(a, b);
    }
    return step;
  }

  std::vector<LonLat> places;   // of the pixels
  std::vector<double> heights;  // metres, of the pack's finest ground; NaN where a pixel shows none
  ViewState view;
  std::shared_ptr<const PackReader> pack;

 private:
  void look_up() {
    const std::vector<float> depth = stage_->target().read_depth();
    PackSampler sampler(*pack, 64);
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        const auto at = static_cast<double>(depth[index(column, row)]);
        places.push_back({});
        heights.push_back(kNone);
        if (at <= 0) continue;
        places.back() = to_geodetic(shown_at(view, column + 0.5, row + 0.5, at)).place;
        const auto height = sampler.height_at(places.back());
        REQUIRE(height.ok());
        // Only where the finest tiles are, whose heights the picture shows.
        if (*height && (*height)->level == kRidgesFinest) heights.back() = (*height)->metres;
      }
    }
  }

  TempDir dir_;
  LonLat place_;
  std::optional<Stage> stage_;
};

bool differs(const gl::Picture& a, const gl::Picture& b, int column, int row, int by) {
  for (int c = 0; c < 3; ++c) {
    if (std::abs(int(a.pixel(column, row)[c]) - int(b.pixel(column, row)[c])) > by) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("a contour line lies where the pack's heights are multiples of its step") {
  for (const std::size_t place : {std::size_t{0}, std::size_t{1}}) {
    Overlay overlay(place);
    const double gap_m = 100;
    const gl::Picture without = overlay.draw(4000, 30, -55);
    overlay.look().contours_m = gap_m;
    const gl::Picture with = overlay.draw(4000, 30, -55);
    int on = 0, off = 0, missing = 0, stray = 0;
    for (int row = 1; row < kHeight - 1; ++row) {
      for (int column = 1; column < kWidth - 1; ++column) {
        const Overlay::Step step = overlay.height_step(column, row);
        if (!(step.most_m < 0.1 * gap_m)) continue;  // where lines fade
        const double lines = overlay.heights[Overlay::index(column, row)] / gap_m;
        const double off_m = std::abs(lines - std::round(lines)) * gap_m;
        const bool is_dark = differs(with, without, column, row, 3);
        if (off_m < 0.25 * step.least_m) {
          ++on;
          missing += !is_dark;
        } else if (off_m > 3 * step.most_m) {
          ++off;
          stray += is_dark;
        }
      }
    }
    CAPTURE(place, on, off);
    CHECK(on > 200);
    CHECK(off > 2000);
    // A line's width is taken from a quad of pixels, one of which may lie beyond a crest or on another
    // triangle.
    CHECK(missing <= on / 200);
    CHECK(stray <= off / 2000);
  }
}

TEST_CASE("ground below the sea's level is under water, and no other") {
  for (const std::size_t place : {std::size_t{0}, std::size_t{1}}) {
    Overlay overlay(place);
    const double level_m = 1000;
    const gl::Picture without = overlay.draw(4000, 30, -55);
    overlay.look().sea_m = level_m;
    const gl::Picture with = overlay.draw(4000, 30, -55);
    int wet = 0, dry = 0, wrong_wet = 0, wrong_dry = 0;
    for (int row = 1; row < kHeight - 1; ++row) {
      for (int column = 1; column < kWidth - 1; ++column) {
        const double height_m = overlay.heights[Overlay::index(column, row)],
                     step_m = overlay.height_step(column, row).most_m;
        if (!(std::abs(height_m - level_m) > 2 * step_m + 0.5)) continue;
        if (height_m < level_m) {
          ++wet;
          wrong_wet += !differs(with, without, column, row, 2);
        } else {
          ++dry;
          wrong_dry += differs(with, without, column, row, 0);
        }
      }
    }
    CAPTURE(place, wet, dry);
    CHECK(wet > 3000);
    CHECK(dry > 3000);
    CHECK(wrong_wet == 0);
    CHECK(wrong_dry == 0);
  }
}

TEST_CASE("slope colours are those of the slope of the pack's ground") {
  Overlay overlay(0);
  const gl::Picture without = overlay.draw(5000, 30, -70);
  overlay.look().slope_colours = true;
  const gl::Picture with = overlay.draw(5000, 30, -70);
  // docs/viewer.md: a colour for each 5 degrees from 25 on.
  const std::array<glm::dvec3, 6> classes = {glm::dvec3(0.4),    {0.95, 0.85, 0.20}, {0.90, 0.50, 0.10},
                                             {0.80, 0.10, 0.08}, {0.55, 0.08, 0.40}, {0.20, 0.08, 0.35}};
  GroundQuery query(overlay.pack);
  const double cell_deg = 1.0 / (1 << kRidgesFinest) / 256;
  std::array<int, 6> counted{}, wrong{};
  for (int row = 1; row < kHeight - 1; row += 2) {
    for (int column = 1; column < kWidth - 1; column += 2) {
      if (std::isnan(overlay.heights[Overlay::index(column, row)])) continue;
      // Where a pixel is as wide as a cell, the filter of the normals reaches two cells.
      double least = 90, most = 0;
      const LonLat at = overlay.places[Overlay::index(column, row)];
      for (int part = 0; part < 25; ++part) {
        const LonLat near{at.lon + (part % 5 - 2) * cell_deg, at.lat + (part / 5 - 2) * cell_deg};
        const auto normal = query.normal(near);
        REQUIRE(normal.ok());
        REQUIRE(normal->has_value());
        const double slope = glm::degrees(std::acos(std::min(1.0, glm::dot(**normal, local_frame(near).up))));
        least = std::min(least, slope);
        most = std::max(most, slope);
      }
      const auto class_of = [](double degrees) {
        return std::clamp(static_cast<int>(degrees / 5) - 4, 0, 5);
      };
      if (class_of(least - 0.5) != class_of(most + 0.5)) continue;
      // Ground that is lit by L is 0.4 L; with the colour C it is (0.35 · 0.4 + 0.65 C) L.
      glm::dvec3 colour(0);
      bool is_bright = true;
      for (int c = 0; c < 3; ++c) {
        const double plain = linear(without.pixel(column, row)[c]);
        is_bright = is_bright && plain > 0.05;
        colour[c] = (linear(with.pixel(column, row)[c]) / plain * 0.4 - 0.35 * 0.4) / 0.65;
      }
      if (!is_bright) continue;
      const auto nearest =
          std::min_element(classes.begin(), classes.end(), [&](const glm::dvec3& a, const glm::dvec3& b) {
            return glm::distance(a, colour) < glm::distance(b, colour);
          });
      const auto expected = static_cast<std::size_t>(class_of(least));
      ++counted[expected];
      wrong[expected] += nearest - classes.begin() != static_cast<std::ptrdiff_t>(expected);
    }
  }
  for (std::size_t i = 0; i < counted.size(); ++i) {
    CAPTURE(i, counted[i]);
    CHECK(counted[i] > 10);
    CHECK(wrong[i] == 0);
  }
}

}  // namespace cairn::test
