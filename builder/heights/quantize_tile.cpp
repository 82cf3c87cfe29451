#include "builder/heights/quantize_tile.h"

#include <cmath>

#include "builder/heights/void_filler.h"
#include "format/simd_clones.h"

namespace cairn {
namespace {

// floor(quanta + 1/2), without the library call that floor() is on a baseline CPU; all in doubles, so that
// loops over it are of vectors.
inline std::int32_t to_nearest(double quanta) {
  const double shifted = quanta + 0.5;
  const auto towards_zero = static_cast<double>(static_cast<std::int32_t>(shifted));
  return static_cast<std::int32_t>(towards_zero - (towards_zero > shifted ? 1.0 : 0.0));
}

// NaN becomes 0.
inline double number_of(float height) {
  return static_cast<double>(height == height ? height : 0.0F);
}

CAIRN_SIMD_CLONES void divide(const float* heights, std::size_t count, double quantum_m,
                              std::int32_t* quanta) {
  for (std::size_t i = 0; i < count; ++i) quanta[i] = to_nearest(number_of(heights[i]) / quantum_m);
}

CAIRN_SIMD_CLONES void multiply(const float* heights, std::size_t count, double per_m, std::int32_t* quanta) {
  for (std::size_t i = 0; i < count; ++i) quanta[i] = to_nearest(number_of(heights[i]) * per_m);
}

void quantise(const std::vector<float>& heights, double quantum_m, std::int32_t* quanta) {
  int exponent = 0;
  const bool power_of_two = std::frexp(quantum_m, &exponent) == 0.5;  // to divide by it is to multiply
  if (power_of_two) return multiply(heights.data(), heights.size(), 1 / quantum_m, quanta);
  divide(heights.data(), heights.size(), quantum_m, quanta);
}

void round_to_steps(const std::vector<float>& heights, const HeightSteps& steps,
                    std::vector<std::int32_t>& quanta) {
  quantise(heights, steps.quantum_m * steps.multiple, quanta.data());
  if (steps.multiple == 1) return;
  for (std::int32_t& q : quanta) q *= steps.multiple;
  for (std::size_t i = 0; i < steps.single.size(); ++i)
    if (steps.single[i] != 0) quanta[i] = to_nearest(number_of(heights[i]) / steps.quantum_m);
}

bool is_void(SampleState state, VoidMode voids) {
  return state == SampleState::none || (state == SampleState::filled && voids == VoidMode::keep);
}

void mark_voids(const MosaicTile& mosaic, VoidMode voids, QuantizedTile& cut) {
  cut.tile.voids.resize(mosaic.states.size());
  std::size_t unsourced = 0;
  bool any = false;
  for (std::size_t i = 0; i < mosaic.states.size(); ++i) {
    const bool hole = is_void(mosaic.states[i], voids);
    cut.tile.voids[i] = hole ? 1 : 0;
    any = any || hole;
    if (mosaic.states[i] != SampleState::sourced) ++unsourced;
  }
  if (!any) cut.tile.voids.clear();
  cut.filled = static_cast<double>(unsourced) / static_cast<double>(mosaic.states.size());
}

}  // namespace

QuantizedTile quantize_tile(const MosaicTile& mosaic, int tile_size, const HeightSteps& steps,
                            VoidMode voids) {
  QuantizedTile cut;
  cut.tile.size = tile_size;
  cut.tile.samples.resize(mosaic.heights.size());
  round_to_steps(mosaic.heights, steps, cut.tile.samples);
  if (!mosaic.states.empty()) mark_voids(mosaic, voids, cut);
  if (!cut.tile.voids.empty()) fill_void_samples(cut.tile);
  return cut;
}

}  // namespace cairn
