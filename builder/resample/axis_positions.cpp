#include "builder/resample/axis_positions.h"

#include <cassert>
#include <cmath>

namespace cairn {

AxisPositions::AxisPositions(LatticeAxis axis, double samples_per_degree)
    : axis_(axis), ratio_(samples_per_degree / axis.posts_per_degree) {
  assert(samples_per_degree > 0 && axis.posts_per_degree > 0);
}

double AxisPositions::position(std::int64_t post) const {
  constexpr double on_sample = 1e-6;
  const double x = (static_cast<double>(post) + axis_.phase) * ratio_;
  const double whole = std::round(x);
  return std::abs(x - whole) < on_sample ? whole : x;
}

std::int64_t AxisPositions::interval_of(std::int64_t post) const {
  return static_cast<std::int64_t>(std::floor(position(post)));
}

double AxisPositions::fraction_of(std::int64_t post) const {
  const double x = position(post);
  return x - std::floor(x);
}

double AxisPositions::post_coordinate(std::int64_t sample) const {
  return static_cast<double>(sample) / ratio_ - axis_.phase;
}

std::int64_t AxisPositions::first_post_from(std::int64_t sample) const {
  const auto k = static_cast<double>(sample);
  auto post = static_cast<std::int64_t>(std::ceil(post_coordinate(sample)));
  while (position(post - 1) >= k) --post;
  while (position(post) < k) ++post;
  return post;
}

bool AxisPositions::is_on_post(std::int64_t sample) const {
  return position(first_post_from(sample)) == static_cast<double>(sample);
}

bool AxisPositions::all_posts_on_samples() const {
  const double first = ratio_ * axis_.phase;
  return ratio_ >= 1 && ratio_ == std::floor(ratio_) && first == std::floor(first);
}

}  // namespace cairn
