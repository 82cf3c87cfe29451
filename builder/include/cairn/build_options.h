#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cairn/bake_choices.h"
#include "cairn/geo.h"
#include "cairn/imagery_options.h"
#include "cairn/pack_layout.h"

namespace cairn {

/// What a bake is asked for. The defaults are the program's.
struct BuildOptions {
  std::vector<std::filesystem::path>
      inputs;  ///< DEMs in the order of the command line, folders and globs expanded; empty: no heights
  ImageryOptions imagery;
  std::filesystem::path target;

  int tile_size = 513;              ///< samples along a side: 513 or 257
  std::optional<int> level;         ///< the finest level of the pack; by default what the finest source needs
  std::optional<int> top;           ///< the coarsest level; by default 0, or kMinLevel for a global input
  std::optional<GeoBounds> region;  ///< only tiles that touch it

  std::optional<double>
      max_error_m;  ///< the error bound E; by default 0.5 for whole-metre sources, 0.05 for others
  std::optional<double> quantum_m;  ///< by default chosen to keep the error bound without waste
  bool allow_error = false;         ///< an exceeded error bound is a warning, not a failure
  ResampleMethod resampling = ResampleMethod::exact;

  VoidMode voids = VoidMode::fill;
  VerticalDatum datum = VerticalDatum::unknown;  ///< of the sources; with a geoid the pack's is the ellipsoid
  std::optional<std::filesystem::path> geoid;    ///< undulations in metres, added to every post

  /// Also stores restricted quadtree triangulations [3]: off by less than so many metres at the finest level,
  /// by less than twice as many at each coarser one.
  std::optional<float> rqt_tolerance_m;

  std::size_t memory_bytes = std::size_t{1024} << 20;  ///< cap on the resident size of the program
  int threads = 0;                                     ///< 0 = all
  bool resume = false;
  bool force = false;
};

}  // namespace cairn
