#include "builder/resample/resample_projected.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>

namespace cairn {
namespace {

constexpr double kReach = 4;                 // posts beyond the extent
constexpr double kPositionTolerance = 1e-3;  // of a post; the fit corrects what comes of it
constexpr double kPlaceTolerance = 1e-5;     // of a sample's height
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::int64_t kLeastStep = 8;  // of the meshes: cells that are too wide are found out by their check

// Vectors that every x86-64 CPU has.
using Float4 = float __attribute__((vector_size(16)));
using Double2 = double __attribute__((vector_size(16)));

template <class Vector, class Number>
Vector load(const Number* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

// Catmull-Rom (Keys 1981, eq. 4, a = -1/2) by Horner's rule.
Float4 cubic_weights(float f) {
  constexpr Float4 cubes{-0.5F, 1.5F, -1.5F, 0.5F}, squares{1, -2.5F, 2, -0.5F}, firsts{-0.5F, 0, 0.5F, 0},
      constants{0, 1, 0, 0};
  return ((cubes * f + squares) * f + firsts) * f + constants;
}

// Heights enter as differences from one of them, which floats hold better than their own height.
float cubic_at(const float* corner, std::int64_t stride, float s, float t) {
  const float base = corner[stride + 1];
  const Float4 down = cubic_weights(t);
  Float4 sum = (load<Float4>(corner) - base) * down[0];
  sum += (load<Float4>(corner + stride) - base) * down[1];
  sum += (load<Float4>(corner + 2 * stride) - base) * down[2];
  sum += (load<Float4>(corner + 3 * stride) - base) * down[3];
  sum *= cubic_weights(s);
  return base + ((sum[0] + sum[1]) + (sum[2] + sum[3]));
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
  void add(const PlanePoint& p) { add(load<Double2>(&p.x)); }
  void add(const PostsAround& other) {
    least_ = other.least_ < least_ ? other.least_ : least_;
    most_ = other.most_ > most_ ? other.most_ : most_;
    finite_ += other.finite_;
  }
  void add(std::span<const PlanePoint> row) {
    PostsAround around;  // a copy that stays in registers
    for (const PlanePoint& p : row) around.add(load<Double2>(&p.x));
    add(around);
  }
  /// Whether every position is a number, and none lies farther than `reach` out of the extent.
  bool are_within(const IndexWindow& extent, double reach) const {
    return finite_[0] == 0 && finite_[1] == 0 && least_[0] >= static_cast<double>(extent.x.first) - reach &&
           most_[0] <= static_cast<double>(extent.x.last) + reach &&
           least_[1] >= static_cast<double>(extent.y.first) - reach &&
           most_[1] <= static_cast<double>(extent.y.last) + reach;
  }
  IndexWindow window(std::int64_t margin) const {
    if (!(least_[0] <= most_[0])) return {};
    return {{static_cast<std::int64_t>(std::floor(least_[0])) - margin,
             static_cast<std::int64_t>(std::ceil(most_[0])) + margin},
            {static_cast<std::int64_t>(std::floor(least_[1])) - margin,
             static_cast<std::int64_t>(std::ceil(most_[1])) + margin}};
  }

 private:
  void add(const Double2& p) {
    least_ = p < least_ ? p : least_;
    most_ = p > most_ ? p : most_;
    finite_ += p - p;
  }

  Double2 least_{HUGE_VAL, HUGE_VAL}, most_{-HUGE_VAL, -HUGE_VAL};
  Double2 finite_{0, 0};  // or NaN, once a position is none
};
static_assert(sizeof(PlanePoint) == sizeof(Double2));

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
  if (std::abs(lat) > 90) return kNowhere;
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
    PostsAround of_row;
    of_row.add(row);
    if (of_row.are_within(extent_, kReach)) {
      posts.add(of_row);
      continue;
    }
    positions.all_in_reach = false;
    for (PlanePoint& p : row) {
      if (is_in_reach(p)) {
        posts.add(p);
      } else {
        p = kNowhere;
      }
    }
  }
  positions.posts = posts.window(2);  // the cubic's reach
  return positions;
}

// Every 16th sample, or 64th where they are dense, stands for those around it: between them a window's bent
// rim leaves their polygon by less than a post, even where samples are whole degrees.
IndexWindow ProjectedResampler::posts_near(IndexWindow samples) const {
  const std::int64_t step = std::max<std::int64_t>(16, projection_mesh_step(samples_per_degree_));
  PostsAround posts;
  for (std::int64_t y = samples.y.first;; y = std::min(y + step, samples.y.last)) {
    for (std::int64_t x = samples.x.first;; x = std::min(x + step, samples.x.last)) {
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

// A window that is wider than half the Earth may meet a post on both its sides.
ProjectionMesh::Box ProjectedResampler::around_window(IndexWindow samples) const {
  const bool wide = static_cast<double>(samples.x.count()) > around() / 2;
  return {{wide ? -HUGE_VAL : static_cast<double>(samples.x.first), static_cast<double>(samples.y.first)},
          {wide ? HUGE_VAL : static_cast<double>(samples.x.last), static_cast<double>(samples.y.last)}};
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
  // Towards a pole a sample becomes as narrow as its parallel is short, and a place counts by the ground.
  const auto tolerance = [this](const PlanePoint& exact) {
    const double across = std::cos((exact.y / samples_per_degree_ - 90) * kDegree);
    return PlanePoint{kPlaceTolerance / std::max(across, kPlaceTolerance), kPlaceTolerance};
  };
  const ProjectionMesh mesh(meshed, std::max(kLeastStep, projection_mesh_step(samples_per_degree_ / 2)),
                            tolerance, place, around_window(samples));
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
  const std::int64_t stride = posts.x.count();
  const auto west = static_cast<double>(posts.x.first), first = static_cast<double>(posts.y.first);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const PlanePoint& place = positions.at[i];
    if (std::isnan(place.x)) {
      out[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const double x = place.x - west, y = place.y - first;  // at least 2: to cut them off is to round down
    const auto column = static_cast<std::int32_t>(x), row = static_cast<std::int32_t>(y);
    const float* corner = heights.data() + (row - 1) * stride + (column - 1);
    out[i] = cubic_at(corner, stride, static_cast<float>(x - column), static_cast<float>(y - row));
  }
}

PostEquations ProjectedResampler::equations(std::span<const float> heights,
                                            std::span<const std::uint8_t> fitted,
                                            std::span<const PlanePoint> shifts,
                                            const SamplePositions& positions,
                                            std::span<std::uint8_t> met) const {
  const IndexWindow& samples = positions.samples;
  const IndexWindow& posts = positions.posts;
  const auto stride = static_cast<std::size_t>(samples.x.count());
  const auto west = static_cast<double>(samples.x.first), south = static_cast<double>(samples.y.first);
  const auto width = static_cast<double>(samples.x.count() - 1);
  const auto height_of_window = static_cast<double>(samples.y.count() - 1);
  PostEquations equations(samples.x.count());
  equations.reserve(static_cast<std::size_t>(posts.count()));
  const auto add = [&](double place_x, double place_y, float height) {
    const double x = place_x - west, y = place_y - south;
    if (!(x >= 0 && y >= 0 && x < width && y < height_of_window)) return;
    const auto i = static_cast<std::int32_t>(x), j = static_cast<std::int32_t>(y);
    const std::size_t corner = static_cast<std::size_t>(j) * stride + static_cast<std::size_t>(i);
    const std::array<std::size_t, 4> square = {corner, corner + 1, corner + stride, corner + stride + 1};
    if (!positions.all_in_reach) {
      for (const std::size_t at : square)
        if (std::isnan(positions.at[at].x)) return;
    }
    equations.add(static_cast<std::int64_t>(corner), x - i, y - j, height);
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
                                                const SamplePositions& positions,
                                                const FitTolerance& tolerance, std::span<float> out,
                                                std::span<std::uint8_t> met) const {
  assert(heights.size() == static_cast<std::size_t>(positions.posts.count()) &&
         fitted.size() == heights.size());
  assert(out.size() == positions.at.size() && (met.empty() || met.size() == out.size()));
  assert(shifts.empty() || shifts.size() == heights.size());
  interpolate(heights, positions, out);
  return equations(heights, fitted, shifts, positions, met).fit(out, tolerance);
}

double posts_per_degree(const Georeference& georeference, IndexWindow posts) {
  double shortest = INFINITY;
  const auto add = [&](double column, double row) {
    const LonLat here = georeference.place_of(column, row);
    for (const LonLat next :
         {georeference.place_of(column + 1, row), georeference.place_of(column, row + 1),
          georeference.place_of(column + 1, row + 1), georeference.place_of(column + 1, row - 1)}) {
      const double step = longer_side(here, next);
      if (std::isfinite(step)) shortest = std::min(shortest, step);
    }
  };
  constexpr int steps = 16;
  const auto part_of = [](IndexRange range, int i) {
    return static_cast<double>(range.first) + static_cast<double>(range.count() - 1) * i / steps;
  };
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) add(part_of(posts.x, i), part_of(posts.y, k));
  }
  // Around a pole neighbours are far apart in longitude, but on the four lines of posts that are meridians.
  for (const double lat : {-90.0, 90.0}) {
    const auto pole = georeference.post_at({0, lat}), again = georeference.post_at({100, lat});
    const double apart = std::abs(pole.column - again.column) + std::abs(pole.row - again.row);
    if (!(apart < 0.01)) continue;
    const auto add_inside = [&](double column, double row) {
      if (column >= static_cast<double>(posts.x.first) && column <= static_cast<double>(posts.x.last) &&
          row >= static_cast<double>(posts.y.first) && row <= static_cast<double>(posts.y.last))
        add(column, row);
    };
    for (int i = 0; i <= steps; ++i) {
      const double column = part_of(posts.x, i);
      add_inside(pole.column, part_of(posts.y, i));
      for (const double slope : {-1.0, 0.0, 1.0})
        add_inside(column, pole.row + slope * (column - pole.column));
    }
  }
  return 1 / shortest;
}

}  // namespace cairn
