#include "builder/resample/post_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "format/simd_clones.h"

namespace cairn {
namespace {

// Eight sums side by side, so that the loop is one of vectors and its bits are those of any vector's width.
CAIRN_SIMD_CLONES double squares(const float* numbers, std::size_t count) {
  constexpr std::size_t lanes = 8;
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const auto v = static_cast<double>(numbers[i + k]);
      sums[k] += v * v;
    }
  }
  double sum = 0;
  for (; i < count; ++i) sum += static_cast<double>(numbers[i]) * static_cast<double>(numbers[i]);
  for (const double s : sums) sum += s;
  return sum;
}

CAIRN_SIMD_CLONES void add_multiple(float* to, float factor, const float* of, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * of[i];
}

// The next direction, of which `gradient` is the new part and cleared.
CAIRN_SIMD_CLONES void turn(float* direction, float keep, float* gradient, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    direction[i] = keep * direction[i] + gradient[i];
    gradient[i] = 0;
  }
}

}  // namespace

void PostEquations::add(std::int64_t corner, double s, double t, float height) {
  const std::array<double, 4> w = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
  const double length = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
  const double unit = 1 / length;
  Row row{static_cast<std::int32_t>(corner), height, static_cast<float>(length), {}};
  for (std::size_t k = 0; k < 4; ++k) row.weights[k] = static_cast<float>(w[k] * unit);
  rows_.push_back(row);
}

float PostEquations::apply(const Row& row, const float* samples) const {
  const float* south = samples + row.corner;
  const float* north = south + columns_;
  return (row.weights[0] * south[0] + row.weights[1] * south[1]) +
         (row.weights[2] * north[0] + row.weights[3] * north[1]);
}

void PostEquations::add_transposed(const Row& row, float factor, float* samples) const {
  float* south = samples + row.corner;
  float* north = south + columns_;
  south[0] += factor * row.weights[0];
  south[1] += factor * row.weights[1];
  north[0] += factor * row.weights[2];
  north[1] += factor * row.weights[3];
}

// Of the scaled rows, what lies beyond the interval; returns the worst unscaled one. Heights enter as
// differences from a sample, which floats hold better than their own height.
double PostEquations::residuals(std::span<const float> samples, double interval_m,
                                std::span<float> out) const {
  const auto interval = static_cast<float>(interval_m);
  double worst = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const float* south = samples.data() + row.corner;
    const float* north = south + columns_;
    const float base = row.height;
    const float sum = (row.weights[0] * (base - south[0]) + row.weights[1] * (base - south[1])) +
                      (row.weights[2] * (base - north[0]) + row.weights[3] * (base - north[1]));
    const float missed = sum * row.length;
    const float beyond = missed - std::clamp(missed, -interval, interval);
    out[i] = interval > 0 ? beyond / row.length : sum;
    worst = std::max(worst, static_cast<double>(std::abs(beyond)));
  }
  return worst;
}

// Takes a step's change of the surface off the residuals, and adds Aᵀ times what is left of them to
// `gradient`: both in one pass, as the rows take more memory than a core has near it. Returns the worst
// residual, unscaled.
double PostEquations::advance(std::span<float> r, float step, const float* direction, float* gradient) const {
  float worst = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    r[i] -= step * apply(row, direction);
    worst = std::max(worst, std::abs(r[i]) * row.length);
    add_transposed(row, r[i], gradient);
  }
  return static_cast<double>(worst);
}

int PostEquations::correct(std::span<float> r, double tolerance_m, int most_rounds,
                           std::span<float> samples) const {
  // Below it a direction is rounding: what remains of the residuals, no change of samples can take away.
  constexpr double least_share = 1e-9;
  const std::size_t count = samples.size();
  std::vector<float> change(count), direction(count), gradient(count);
  for (std::size_t i = 0; i < rows_.size(); ++i) add_transposed(rows_[i], r[i], direction.data());
  double before = squares(r.data(), r.size());
  int rounds = 0;
  for (bool within = false; !within && rounds < most_rounds; ++rounds) {
    const double length = squares(direction.data(), count);
    if (length < least_share * before) break;
    const auto step = static_cast<float>(before / length);
    add_multiple(change.data(), step, direction.data(), count);
    within = advance(r, step, direction.data(), gradient.data()) <= tolerance_m;
    const double after = squares(r.data(), r.size());
    turn(direction.data(), static_cast<float>(after / before), gradient.data(), count);
    before = after;
  }
  add_multiple(samples.data(), 1, change.data(), count);
  return rounds;
}

PostEquations::Fit PostEquations::fit(std::span<float> samples, const FitTolerance& tolerance) const {
  constexpr int most_rounds = 300;
  std::vector<float> r(rows_.size());
  Fit fit{0, residuals(samples, tolerance.interval_m, r)};
  // The residuals that the rounds carry along drift from the true ones, so these are worked out anew at the
  // end.
  while (fit.worst_residual_m > tolerance.tolerance_m && fit.rounds < most_rounds) {
    fit.rounds += correct(r, 0.9 * tolerance.tolerance_m, most_rounds - fit.rounds, samples);
    const double before = fit.worst_residual_m;
    fit.worst_residual_m = residuals(samples, tolerance.interval_m, r);
    if (fit.worst_residual_m > before / 2) break;
  }
  return fit;
}

}  // namespace cairn
