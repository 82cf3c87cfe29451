#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// The ground that a scattered object may stand on.
struct GroundLimits {
  double min_height_m = -std::numeric_limits<double>::infinity();  ///< in the pack's vertical datum
  double max_height_m = std::numeric_limits<double>::infinity();
  double min_slope_deg = 0;
  double max_slope_deg = 90;

  bool has_slope() const { return min_slope_deg > 0 || max_slope_deg < 90; }
};

/// How objects are scattered in a polygon.
struct ScatterRule {
  struct Share {
    std::string model;
    double weight = 1;
  };
  std::vector<Share> models;
  double per_hectare = 0;
  double spacing_m = 0;  ///< the least distance of two objects
  std::uint64_t seed = 0;
  double min_scale = 1;
  double max_scale = 1;
  std::optional<double> heading_degrees;  ///< of all; any where it is not given
  GroundLimits limits;
};

/// Sets a rule's models from a text such as "fir:3,oak", where a model without a number has the weight 1.
Status set_models(std::string_view text, ScatterRule& rule);

/// Returns what is wrong with a rule, if anything.
Status check_rule(const ScatterRule& rule);

/// A polygon or several, with a rule. A place is inside where a line from it crosses rings an odd number of
/// times. Edges are straight in longitude and latitude.
struct ScatterArea {
  ScatterRule rule;
  std::vector<std::vector<LonLat>> rings;  ///< the last vertex need not be the first
};

/// Returns what is wrong with the area's vertices or its rule, if anything.
Status check_area(const ScatterArea& area);

}  // namespace cairn
