#include "builder/resample/resample_projected.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "builder/resample/cubic_kernel.h"

namespace cairn {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
constexpr double kReach = 4;                 // posts beyond the extent
constexpr double kPositionTolerance = 1e-3;  // of a post; the fit corrects what comes of it
constexpr double kPlaceTolerance = 1e-5;     // of a sample
constexpr std::int64_t kLeastStep = 8;  // of the meshes: cells that are too wide are found out by their check

float cubic_at(const float* corner, std::int64_t stride, double s, double t) {
  const auto ws = catmull_rom(s);
  const auto wt = catmull_rom(t);
  double sum = 0;
  for (std::size_t r = 0; r < 4; ++r, corner += stride) {
    double row = 0;
    for (std::size_t c = 0; c < 4; ++c) row += ws[c] * static_cast<double>(corner[c]);
    sum += wt[r] * row;
  }
  return static_cast<float>(sum);
}

double longer_side(LonLat a, LonLat b) {
  return std::max(std::abs(std::remainder(a.lon - b.lon, 360)), std::abs(a.lat - b.lat));
}

double middle_of(IndexRange range) {
  return (static_cast<double>(range.first) + static_cast<double>(range.last)) / 2;
}

/// The posts around positions, `margin` more on each side.
class PostsAround {
 public:
  void add(const PlanePoint& p) {
    west_ = std::min(west_, p.x);
    east_ = std::max(east_, p.x);
    north_ = std::min(north_, p.y);
    south_ = std::max(south_, p.y);
  }
  IndexWindow window(std::int64_t margin) const {
    if (!(west_ <= east_)) return {};
    return {{static_cast<std::int64_t>(std::floor(west_)) - margin,
             static_cast<std::int64_t>(std::ceil(east_)) + margin},
            {static_cast<std::int64_t>(std::floor(north_)) - margin,
             static_cast<std::int64_t>(std::ceil(south_)) + margin}};
  }

 private:
  double west_ = HUGE_VAL, east_ = -HUGE_VAL, north_ = HUGE_VAL, south_ = -HUGE_VAL;
};

}  // namespace

ProjectedResampler::ProjectedResampler(const Georeference& georeference, IndexWindow extent,
                                       double samples_per_degree)
    : georeference_(georeference), extent_(extent), samples_per_degree_(samples_per_degree) {
  assert(samples_per_degree > 0);
  const double lon = georeference.place_of(middle_of(extent.x), middle_of(extent.y)).lon;
  middle_lon_ = std::isfinite(lon) ? lon : 0;
}

bool ProjectedResampler::is_well_conditioned() const {
  return samples_per_degree_ >= 1.03 * posts_per_degree(georeference_, extent_);
}

// Beyond a pole there is no place.
PlanePoint ProjectedResampler::position_of(std::int64_t x, std::int64_t y) const {
  const double lat = static_cast<double>(y) / samples_per_degree_ - 90;
  if (std::abs(lat) > 90) return {kNowhere, kNowhere};
  const double lon = static_cast<double>(x) / samples_per_degree_ - 180;
  const auto post = georeference_.post_at({middle_lon_ + std::remainder(lon - middle_lon_, 360), lat});
  return {post.column, post.row};
}

bool ProjectedResampler::is_in_reach(const PlanePoint& p) const {
  return p.x >= static_cast<double>(extent_.x.first) - kReach &&
         p.x <= static_cast<double>(extent_.x.last) + kReach &&
         p.y >= static_cast<double>(extent_.y.first) - kReach &&
         p.y <= static_cast<double>(extent_.y.last) + kReach;
}

SamplePositions ProjectedResampler::positions_of(IndexWindow samples) const {
  SamplePositions positions{samples, {}, {}};
  const ProjectionMesh mesh(samples, std::max(kLeastStep, projection_mesh_step(samples_per_degree_)),
                            kPositionTolerance,
                            [this](std::int64_t x, std::int64_t y) { return position_of(x, y); });
  positions.at.resize(static_cast<std::size_t>(samples.count()));
  PostsAround posts;
  const auto columns = static_cast<std::size_t>(samples.x.count());
  for (std::int64_t y = samples.y.first; y <= samples.y.last; ++y) {
    const std::span<PlanePoint> row(&positions.at[samples.offset(samples.x.first, y)], columns);
    mesh.row(y, row);
    for (PlanePoint& p : row) {
      if (is_in_reach(p)) {
        posts.add(p);
      } else {
        p = {kNowhere, kNowhere};
      }
    }
  }
  positions.posts = posts.window(2);  // the cubic's reach
  return positions;
}

// Every 16th sample stands for those around it: between them a window's bent rim leaves their polygon by less
// than a post, even where samples are whole degrees.
IndexWindow ProjectedResampler::posts_near(IndexWindow samples) const {
  constexpr std::int64_t kStep = 16;
  PostsAround posts;
  for (std::int64_t y = samples.y.first;; y = std::min(y + kStep, samples.y.last)) {
    for (std::int64_t x = samples.x.first;; x = std::min(x + kStep, samples.x.last)) {
      PlanePoint p = position_of(x, y);
      const auto within = [](double at, IndexRange range) {
        return std::clamp(at, static_cast<double>(range.first) - kReach,
                          static_cast<double>(range.last) + kReach);
      };
      if (std::isfinite(p.x) && std::isfinite(p.y))
        posts.add({within(p.x, extent_.x), within(p.y, extent_.y)});
      if (x == samples.x.last) break;
    }
    if (y == samples.y.last) break;
  }
  const IndexWindow around = posts.window(3);
  return {{std::max(around.x.first, extent_.x.first), std::min(around.x.last, extent_.x.last)},
          {std::max(around.y.first, extent_.y.first), std::min(around.y.last, extent_.y.last)}};
}

void ProjectedResampler::visit_places(IndexWindow posts, IndexWindow samples,
                                      std::span<const PlanePoint> shifts, const VisitPlaces& visit) const {
  const double middle = middle_of(samples.x), turn = around();
  const auto place = [this, middle, turn](std::int64_t column, std::int64_t row) {
    const LonLat at = georeference_.place_of(static_cast<double>(column), static_cast<double>(row));
    const double x = (at.lon + 180) * samples_per_degree_;
    return PlanePoint{middle + std::remainder(x - middle, turn), (at.lat + 90) * samples_per_degree_};
  };
  IndexWindow meshed = posts;
  if (!shifts.empty()) meshed = {{posts.x.first, posts.x.last + 1}, {posts.y.first, posts.y.last + 1}};
  const ProjectionMesh mesh(meshed, std::max(kLeastStep, projection_mesh_step(samples_per_degree_ / 2)),
                            kPlaceTolerance, place);
  std::vector<PlanePoint> row(static_cast<std::size_t>(meshed.x.count())), next(row.size());
  for (std::int64_t y = posts.y.first; y <= posts.y.last; ++y) {
    mesh.row(y, row);
    if (shifts.empty()) {
      visit(y, row);
      continue;
    }
    mesh.row(y + 1, next);
    const std::size_t first = posts.offset(posts.x.first, y);
    for (std::size_t c = 0; c + 1 < row.size(); ++c) {
      const PlanePoint shift = shifts[first + c], east = row[c + 1], down = next[c];
      row[c] = {row[c].x + shift.x * (east.x - row[c].x) + shift.y * (down.x - row[c].x),
                row[c].y + shift.x * (east.y - row[c].y) + shift.y * (down.y - row[c].y)};
    }
    visit(y, std::span<const PlanePoint>(row).first(row.size() - 1));
  }
}

void ProjectedResampler::interpolate(std::span<const float> heights, const SamplePositions& positions,
                                     std::span<float> out) const {
  const IndexWindow& posts = positions.posts;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const PlanePoint& place = positions.at[i];
    if (std::isnan(place.x)) {
      out[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const double column = std::floor(place.x);
    const double line = std::floor(place.y);
    const auto corner =
        posts.offset(static_cast<std::int64_t>(column) - 1, static_cast<std::int64_t>(line) - 1);
    out[i] = cubic_at(&heights[corner], posts.x.count(), place.x - column, place.y - line);
  }
}

PostEquations ProjectedResampler::equations(std::span<const float> heights,
                                            std::span<const std::uint8_t> fitted,
                                            std::span<const PlanePoint> shifts,
                                            const SamplePositions& positions,
                                            std::span<std::uint8_t> met) const {
  const IndexWindow& samples = positions.samples;
  const IndexWindow& posts = positions.posts;
  const IndexWindow corners{{samples.x.first, samples.x.last - 1}, {samples.y.first, samples.y.last - 1}};
  const auto stride = static_cast<std::size_t>(samples.x.count());
  PostEquations equations(samples.x.count());
  const auto add = [&](double x, double y, float height) {
    const double x0 = std::floor(x), y0 = std::floor(y);
    const auto i = static_cast<std::int64_t>(x0);
    const auto j = static_cast<std::int64_t>(y0);
    if (!corners.x.holds(i) || !corners.y.holds(j)) return;
    const std::size_t corner = samples.offset(i, j);
    const std::array<std::size_t, 4> square = {corner, corner + 1, corner + stride, corner + stride + 1};
    for (const std::size_t at : square)
      if (std::isnan(positions.at[at].x)) return;
    equations.add(static_cast<std::int64_t>(corner), x - x0, y - y0, height);
    if (met.empty()) return;
    for (const std::size_t at : square) met[at] = 1;
  };
  // A window that is wider than half the Earth may meet a post on both its sides.
  const bool wide = static_cast<double>(samples.x.count()) > around() / 2;
  visit_places(posts, samples, shifts, [&](std::int64_t y, std::span<const PlanePoint> places) {
    const std::size_t first = posts.offset(posts.x.first, y);
    for (std::size_t c = 0; c < places.size(); ++c) {
      if (fitted[first + c] == 0 || !std::isfinite(places[c].x)) continue;
      add(places[c].x, places[c].y, heights[first + c]);
      if (!wide) continue;
      add(places[c].x - around(), places[c].y, heights[first + c]);
      add(places[c].x + around(), places[c].y, heights[first + c]);
    }
  });
  return equations;
}

PostEquations::Fit ProjectedResampler::resample(std::span<const float> heights,
                                                std::span<const std::uint8_t> fitted,
                                                std::span<const PlanePoint> shifts,
                                                const SamplePositions& positions, double tolerance_m,
                                                std::span<float> out, std::span<std::uint8_t> met) const {
  assert(heights.size() == static_cast<std::size_t>(positions.posts.count()) &&
         fitted.size() == heights.size());
  assert(out.size() == positions.at.size() && (met.empty() || met.size() == out.size()));
  assert(shifts.empty() || shifts.size() == heights.size());
  interpolate(heights, positions, out);
  return equations(heights, fitted, shifts, positions, met).fit(out, tolerance_m);
}

double posts_per_degree(const Georeference& georeference, IndexWindow posts) {
  double shortest = INFINITY;
  constexpr int steps = 16;
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) {
      const double column =
          static_cast<double>(posts.x.first) + static_cast<double>(posts.x.count() - 1) * i / steps;
      const double row =
          static_cast<double>(posts.y.first) + static_cast<double>(posts.y.count() - 1) * k / steps;
      const LonLat here = georeference.place_of(column, row);
      for (const LonLat next :
           {georeference.place_of(column + 1, row), georeference.place_of(column, row + 1),
            georeference.place_of(column + 1, row + 1), georeference.place_of(column + 1, row - 1)}) {
        const double step = longer_side(here, next);
        if (std::isfinite(step)) shortest = std::min(shortest, step);
      }
    }
  }
  return 1 / shortest;
}

}  // namespace cairn
