#pragma once

#include <optional>

#include "runtime/scene/scene_map.h"

namespace cairn {

/// The largest block counts over 20 random moves, K = 4, that Melkisetoğlu 2005 gives (figures 8.6.6
/// and 8.6.5).
struct PublishedCounts {
  int total = 0;
  int difference = 0;
};

/// Returns nullopt where nothing was published.
constexpr std::optional<PublishedCounts> published_counts(RefinementPattern pattern, int levels) {
  if (levels != 4) return std::nullopt;
  switch (pattern) {
    case RefinementPattern::normal:
      return PublishedCounts{13, 11};
    case RefinementPattern::plus:
      return PublishedCounts{35, 11};
    case RefinementPattern::cross:
      return PublishedCounts{44, 22};
    case RefinementPattern::restricted:
      return PublishedCounts{52, 10};
    default:
      return std::nullopt;
  }
}

}  // namespace cairn
