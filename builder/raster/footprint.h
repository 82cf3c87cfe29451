#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>
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

  /// The place in a rectangle that is nearest, by the larger of the two axes' distances; itself inside, and
  /// where there are no rectangles. Its longitude is counted on from the place's.
  LonLat nearest_to(LonLat place) const;

  /// The rectangles that come within `margin` degrees of this one.
  Footprint near(const GeoBounds& rectangle, double margin) const;

  /// Whether one rectangle alone holds all of this one.
  bool contains(const GeoBounds& rectangle) const;

  /// Whether the rectangle, grown by `margin` degrees, shares an area of more than a line with the footprint.
  bool overlaps(const GeoBounds& rectangle, double margin = 0) const;

 private:
  /// Calls visit(rectangle) for all that may come within `margin` degrees of the area, until one returns
  /// true; returns whether one did.
  template <class Visit>
  bool any_near(const GeoBounds& area, double margin, const Visit& visit) const;

  /// Numbers of rectangles of about one size, by cells as large as they are, so that thousands of files cost
  /// no more than a few.
  struct Scale {
    std::unordered_map<std::int64_t, std::vector<std::uint32_t>> by_cell;
    std::vector<std::uint32_t> all;
  };

  std::vector<GeoBounds> rectangles_;
  std::map<int, Scale> scales_;  // a cell of scale e is 2^-e degrees wide
};

}  // namespace cairn
