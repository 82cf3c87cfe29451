#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cairn/bake_choices.h"
#include "cairn/geo.h"
#include "cairn/source_rule.h"
#include "cairn/texture_tile.h"

namespace cairn {

/// What the imagery layer of a bake is asked for.
struct ImageryOptions {
  std::vector<std::filesystem::path> inputs;  ///< in the order of the command line; empty: no such layer
  std::vector<SourceRule> source_rules;       ///< of two that match an image the later one wins
  std::optional<GeoBounds> bounds;            ///< of images that do not say where they lie: their outer edges
  /// bc1: where a tile is not opaque all over it becomes bc3.
  TextureFormat format = TextureFormat::bc1;
  TextureQuality quality = TextureQuality::normal;
  double feather_pixels = 0;  ///< over which an image's rim fades into the images beneath
};

}  // namespace cairn
