#include "builder/resample/resample_projected.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "builder/resample/cubic_kernel.h"
#include "builder/resample/projection_mesh.h"

namespace cairn {
namespace {

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
  return std::max(std::abs(a.lon - b.lon), std::abs(a.lat - b.lat));
}

}  // namespace

ProjectedResampler::ProjectedResampler(const Georeference& georeference, double samples_per_degree)
    : georeference_(georeference), samples_per_degree_(samples_per_degree) {
  assert(samples_per_degree > 0);
}

bool ProjectedResampler::is_well_conditioned(IndexWindow posts) const {
  return samples_per_degree_ >= 1.03 * posts_per_degree(georeference_, posts);
}

LonLat ProjectedResampler::place_of_sample(double x, double y) const {
  return {x / samples_per_degree_ - 180, y / samples_per_degree_ - 90};
}

IndexWindow ProjectedResampler::posts_for(IndexWindow samples) const {
  constexpr std::int64_t sides = 32;  // of a polygon that stands for the window's bent edges
  double west = INFINITY, east = -INFINITY, north = INFINITY, south = -INFINITY;
  for (std::int64_t k = 0; k <= sides; ++k) {
    const double f = static_cast<double>(k) / static_cast<double>(sides);
    const double x = static_cast<double>(samples.x.first) + f * static_cast<double>(samples.x.count() - 1);
    const double y = static_cast<double>(samples.y.first) + f * static_cast<double>(samples.y.count() - 1);
    for (const LonLat place : {place_of_sample(x, static_cast<double>(samples.y.first)),
                               place_of_sample(x, static_cast<double>(samples.y.last)),
                               place_of_sample(static_cast<double>(samples.x.first), y),
                               place_of_sample(static_cast<double>(samples.x.last), y)}) {
      const auto post = georeference_.post_at(place);
      west = std::min(west, post.column);
      east = std::max(east, post.column);
      north = std::min(north, post.row);
      south = std::max(south, post.row);
    }
  }
  constexpr std::int64_t margin = 3;  // the cubic's two, and one for the bend between the polygon's corners
  return {{static_cast<std::int64_t>(std::floor(west)) - margin,
           static_cast<std::int64_t>(std::ceil(east)) + margin},
          {static_cast<std::int64_t>(std::floor(north)) - margin,
           static_cast<std::int64_t>(std::ceil(south)) + margin}};
}

void ProjectedResampler::interpolate(IndexWindow posts, std::span<const float> heights, IndexWindow samples,
                                     std::span<float> out) const {
  const ProjectionMesh mesh(
      samples, projection_mesh_step(samples_per_degree_), [this](std::int64_t x, std::int64_t y) {
        const auto post =
            georeference_.post_at(place_of_sample(static_cast<double>(x), static_cast<double>(y)));
        return PlanePoint{post.column, post.row};
      });
  std::vector<PlanePoint> row(static_cast<std::size_t>(samples.x.count()));
  for (std::int64_t y = samples.y.first; y <= samples.y.last; ++y) {
    mesh.row(y, row);
    for (const PlanePoint& place : row) {
      const double column = std::floor(place.x);
      const double line = std::floor(place.y);
      const auto corner =
          posts.offset(static_cast<std::int64_t>(column) - 1, static_cast<std::int64_t>(line) - 1);
      out[static_cast<std::size_t>(&place - row.data()) + samples.offset(samples.x.first, y)] =
          cubic_at(&heights[corner], posts.x.count(), place.x - column, place.y - line);
    }
  }
}

PostEquations ProjectedResampler::equations(IndexWindow posts, std::span<const float> heights,
                                            IndexWindow samples) const {
  const double across = longer_side(
      georeference_.place_of(static_cast<double>(posts.x.first), static_cast<double>(posts.y.first)),
      georeference_.place_of(static_cast<double>(posts.x.first + 1), static_cast<double>(posts.y.first)));
  const ProjectionMesh mesh(
      posts, projection_mesh_step(1 / across), [this](std::int64_t column, std::int64_t row) {
        const LonLat place = georeference_.place_of(static_cast<double>(column), static_cast<double>(row));
        return PlanePoint{(place.lon + 180) * samples_per_degree_, (place.lat + 90) * samples_per_degree_};
      });
  const IndexWindow corners{{samples.x.first, samples.x.last - 1}, {samples.y.first, samples.y.last - 1}};
  PostEquations equations(samples.x.count());
  std::vector<PlanePoint> row(static_cast<std::size_t>(posts.x.count()));
  for (std::int64_t y = posts.y.first; y <= posts.y.last; ++y) {
    mesh.row(y, row);
    for (std::size_t c = 0; c < row.size(); ++c) {
      const double x0 = std::floor(row[c].x);
      const double y0 = std::floor(row[c].y);
      const auto i = static_cast<std::int64_t>(x0);
      const auto j = static_cast<std::int64_t>(y0);
      if (!corners.x.holds(i) || !corners.y.holds(j)) continue;
      equations.add(static_cast<std::int64_t>(samples.offset(i, j)), row[c].x - x0, row[c].y - y0,
                    heights[posts.offset(posts.x.first, y) + c]);
    }
  }
  return equations;
}

PostEquations::Fit ProjectedResampler::resample(std::span<const float> heights, IndexWindow samples,
                                                double tolerance_m, std::span<float> out) const {
  const IndexWindow posts = posts_for(samples);
  assert(heights.size() == static_cast<std::size_t>(posts.count()));
  assert(out.size() == static_cast<std::size_t>(samples.count()));
  interpolate(posts, heights, samples, out);
  return equations(posts, heights, samples).fit(out, tolerance_m);
}

double posts_per_degree(const Georeference& georeference, IndexWindow posts) {
  double shortest = INFINITY;
  constexpr int steps = 8;
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
        shortest = std::min(shortest, longer_side(here, next));
      }
    }
  }
  return 1 / shortest;
}

}  // namespace cairn
