#include "builder/resample/post_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace cairn {
namespace {

double squares(std::span<const float> numbers) {
  double sum = 0;
  for (const float v : numbers) sum += static_cast<double>(v) * static_cast<double>(v);
  return sum;
}

void add_multiple(std::span<float> to, float factor, std::span<const float> of) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * of[i];
}

}  // namespace

void PostEquations::add(std::int64_t corner, double s, double t, float height) {
  const std::array<double, 4> w = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
  const double length = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
  Row row{static_cast<std::int32_t>(corner), height, static_cast<float>(length), {}};
  for (std::size_t k = 0; k < 4; ++k) row.weights[k] = static_cast<float>(w[k] / length);
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

// Of the scaled rows; returns the worst unscaled one. Heights enter as differences from a sample, which
// floats hold better than their own height.
double PostEquations::residuals(std::span<const float> samples, std::span<float> out) const {
  double worst = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const float* south = samples.data() + row.corner;
    const float* north = south + columns_;
    const float base = row.height;
    const float sum = (row.weights[0] * (base - south[0]) + row.weights[1] * (base - south[1])) +
                      (row.weights[2] * (base - north[0]) + row.weights[3] * (base - north[1]));
    out[i] = sum;
    worst = std::max(worst, static_cast<double>(std::abs(sum) * row.length));
  }
  return worst;
}

int PostEquations::correct(std::span<float> r, double tolerance_m, int most_rounds,
                           std::span<float> samples) const {
  // Below it a direction is rounding: what remains of the residuals, no change of samples can take away.
  constexpr double least_share = 1e-9;
  std::vector<float> change(samples.size());
  std::vector<float> direction(samples.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) add_transposed(rows_[i], r[i], direction.data());
  double before = squares(r);
  int rounds = 0;
  for (bool within = false; !within && rounds < most_rounds; ++rounds) {
    const double length = squares(direction);
    if (length < least_share * before) break;
    const auto step = static_cast<float>(before / length);
    add_multiple(change, step, direction);
    within = true;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      r[i] -= step * apply(rows_[i], direction.data());
      within = within && static_cast<double>(std::abs(r[i]) * rows_[i].length) <= tolerance_m;
    }
    const double after = squares(r);
    const auto keep = static_cast<float>(after / before);
    for (float& d : direction) d *= keep;
    for (std::size_t i = 0; i < rows_.size(); ++i) add_transposed(rows_[i], r[i], direction.data());
    before = after;
  }
  add_multiple(samples, 1, change);
  return rounds;
}

PostEquations::Fit PostEquations::fit(std::span<float> samples, double tolerance_m) const {
  constexpr int most_rounds = 300;
  std::vector<float> r(rows_.size());
  Fit fit{0, residuals(samples, r)};
  // The residuals that the rounds carry along drift from the true ones, so these are worked out anew at the
  // end.
  while (fit.worst_residual_m > tolerance_m && fit.rounds < most_rounds) {
    fit.rounds += correct(r, 0.9 * tolerance_m, most_rounds - fit.rounds, samples);
    const double before = fit.worst_residual_m;
    fit.worst_residual_m = residuals(samples, r);
    if (fit.worst_residual_m > before / 2) break;
  }
  return fit;
}

}  // namespace cairn
