#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cairn/bake_choices.h"
#include "cairn/pack_layout.h"
#include "cairn/source_rule.h"

namespace cairn {

/// How DEMs become one surface.
struct MosaicOptions {
  /// DEMs in the order of the command line, folders and globs expanded. None: the pack has no heights.
  std::vector<std::filesystem::path> inputs;
  std::optional<int> level;  ///< the finest level; by default what the finest source needs
  /// The error bound E in metres; by default 0.5 for whole-metre sources, 0.05 for others.
  std::optional<double> max_error_m;
  ResampleMethod resampling = ResampleMethod::smooth;
  /// Of the sources; by default what they all say of themselves. With a geoid the pack's is the ellipsoid.
  std::optional<VerticalDatum> datum;
  std::optional<std::filesystem::path> geoid;  ///< undulations in metres, added to every post
  std::vector<SourceRule> source_rules;        ///< of two that match a source the later one wins
  /// Posts of the source beneath over which the difference of the one above fades, beyond that one's rim; 0
  /// for a step.
  double fade_posts = 1;
  /// Posts from one with a value up to which voids are filled; farther in a void stays one. 0 to 256; by
  /// default any distance.
  std::optional<double> void_posts;
};

}  // namespace cairn
