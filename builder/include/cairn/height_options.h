#pragma once

#include <optional>

#include "cairn/bake_choices.h"

namespace cairn {

/// How a surface becomes height tiles.
struct HeightOptions {
  std::optional<double> quantum_m;  ///< by default chosen to keep the error bound without waste
  bool allow_error = false;         ///< an exceeded error bound is a warning, not a failure
  VoidMode voids = VoidMode::fill;

  /// Also stores restricted quadtree triangulations (docs/pack-format.md): off by less than so many metres at
  /// the finest level, by less than twice as many at each coarser one.
  std::optional<float> rqt_tolerance_m;
};

}  // namespace cairn
