#include "builder/heights/leaf_error.h"

#include <algorithm>
#include <limits>

namespace cairn {
namespace {

SurfaceError worse_of(const SurfaceError& a, const SurfaceError& b) {
  return {std::max(a.max_m, b.max_m), a.has_holes || b.has_holes};
}

}  // namespace

LeafErrors::LeafErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
                       const PostCounting& counting)
    : tile_(tile), quantum_m_(quantum_m), posts_(posts), counting_(counting) {
  for (const auto& p : posts_)
    own_ = worse_of(own_, measure_own_surface(tile_, quantum_m_, p, counting_, own_stats_, own_errors_));
  if (AncestorErrors::can_measure(tile_, posts_)) ancestors_.emplace(tile_, quantum_m_, posts_, own_errors_);
}

double LeafErrors::max_m(int up) const {
  if (ancestors_) return ancestors_->max_m(up);
  return std::max(of_posts(up).max_m, measure_surface(tile_, quantum_m_, up, samples_as_posts()).max_m);
}

bool LeafErrors::keeps(int up, double error_bound_m, double max_m) const {
  if (ancestors_) return max_m <= error_bound_m || !ancestors_->any_post_beyond(up, error_bound_m);
  const SurfaceError error = of_posts(up);
  return error.max_m <= error_bound_m && !error.has_holes;
}

ErrorStats LeafErrors::stats(int up, double max_m) const {
  if (max_m == 0 && own_.max_m == 0 && !own_.has_holes) return own_stats_;
  ErrorStats stats;
  for (const auto& p : posts_) measure_surface(tile_, quantum_m_, up, p, counting_, stats);
  return stats;
}

SurfaceError LeafErrors::of_posts(int up) const {
  SurfaceError worst;
  for (const auto& p : posts_) worst = worse_of(worst, measure_surface(tile_, quantum_m_, up, p));
  return worst;
}

MeasuredPosts LeafErrors::samples_as_posts() const {
  MeasuredPosts samples;
  for (int i = 0; i < tile_.size; ++i) samples.xs.push_back(i);
  samples.ys = samples.xs;
  samples.heights.reserve(tile_.samples.size());
  for (std::size_t i = 0; i < tile_.samples.size(); ++i) {
    const bool is_void = !tile_.voids.empty() && tile_.voids[i] != 0;
    samples.heights.push_back(is_void ? std::numeric_limits<float>::quiet_NaN()
                                      : static_cast<float>(tile_.samples[i] * quantum_m_));
  }
  return samples;
}

}  // namespace cairn
