#include "builder/tile_cutter.h"

#include <cmath>

#include "builder/void_level.h"

namespace cairn {
namespace {

// floor(quanta + 1/2), without the library call that floor() is on a baseline CPU.
std::int32_t to_nearest(double quanta) {
  const double shifted = quanta + 0.5;
  const auto towards_zero = static_cast<std::int32_t>(shifted);
  return towards_zero - (static_cast<double>(towards_zero) > shifted ? 1 : 0);
}

bool is_void(SampleState state, VoidMode voids) {
  return state == SampleState::none || (state == SampleState::filled && voids == VoidMode::keep);
}

void mark_voids(const MosaicTile& mosaic, VoidMode voids, CutTile& cut) {
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

CutTile cut_tile(const MosaicTile& mosaic, int tile_size, double quantum_m, VoidMode voids) {
  CutTile cut;
  cut.tile.size = tile_size;
  cut.tile.samples.resize(mosaic.heights.size());
  for (std::size_t i = 0; i < mosaic.heights.size(); ++i) {
    cut.tile.samples[i] =
        std::isnan(mosaic.heights[i]) ? 0 : to_nearest(static_cast<double>(mosaic.heights[i]) / quantum_m);
  }
  if (!mosaic.states.empty()) mark_voids(mosaic, voids, cut);
  if (!cut.tile.voids.empty()) level_voids(cut.tile);
  return cut;
}

}  // namespace cairn
