#include "builder/app/region_argument.h"

#include <cassert>
#include <cmath>

namespace cairn {

Result<GeoBounds> region_of(const std::vector<double>& numbers) {
  assert(numbers.size() == 4);
  GeoBounds region{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (region.east <= region.west) region.east += 360;
  const bool sane = std::abs(region.west) <= 360 && region.width() > 0 && region.width() <= 360 &&
                    region.south >= -90 && region.south < region.north && region.north <= 90;
  if (sane) return region;
  return usage_error("--region: expected WEST,SOUTH,EAST,NORTH in degrees, found another order or range");
}

}  // namespace cairn
