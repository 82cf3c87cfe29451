#include "builder/mosaic/source_group.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn {

GeoBounds SourceGroup::widened(GeoBounds area, double margin) {
  constexpr double degree = std::numbers::pi / 180;
  const double lat = std::min(std::max(std::abs(area.south), std::abs(area.north)) + margin, 90.0);
  const double all_around = std::max(0.0, 180 - area.width() / 2);
  const double wider = std::min(margin / std::max(std::cos(lat * degree), 1e-9) - margin, all_around);
  area.west -= wider;
  area.east += wider;
  return area;
}

}  // namespace cairn
