#pragma once

#include <optional>

#include "runtime/scene/scene_map.h"

namespace cairn {

/// The largest block counts that seed [4] gives, K = 4, over 20 random moves: figures 8.6.6 and 8.6.5.
struct ThesisCounts {
  int total = 0;
  int difference = 0;
};

constexpr std::optional<ThesisCounts> thesis_counts(RefinementPattern pattern, int levels) {
  if (levels != 4) return std::nullopt;
  switch (pattern) {
    case RefinementPattern::normal:
      return ThesisCounts{13, 11};
    case RefinementPattern::plus:
      return ThesisCounts{35, 11};
    case RefinementPattern::cross:
      return ThesisCounts{44, 22};
    case RefinementPattern::restricted:
      return ThesisCounts{52, 10};
    default:
      return std::nullopt;
  }
}

}  // namespace cairn
