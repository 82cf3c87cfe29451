#pragma once

#include <vector>

#include "cairn/geo.h"

namespace cairn {

/// Where a group of sources reaches: rectangles in degrees, each around the outermost posts of one raster.
/// Longitudes are compared around the Earth.
class Footprint {
 public:
  void add(const GeoBounds& rectangle);

  const std::vector<GeoBounds>& rectangles() const { return rectangles_; }

  /// The smallest rectangle around all, as they stand on either side of the antimeridian, but never wider
  /// than the Earth.
  GeoBounds bounds() const;

  /// Degrees from the place to the nearest rectangle, the larger of the two axes' distances; 0 inside.
  double distance_to(LonLat place) const;

  /// The rectangles that come within `margin` degrees of this one.
  Footprint near(const GeoBounds& rectangle, double margin) const;

  /// Whether one rectangle alone holds all of this one.
  bool contains(const GeoBounds& rectangle) const;

  /// Whether the rectangle, grown by `margin` degrees, shares an area of more than a line with the footprint.
  bool overlaps(const GeoBounds& rectangle, double margin = 0) const;

 private:
  std::vector<GeoBounds> rectangles_;
};

}  // namespace cairn
