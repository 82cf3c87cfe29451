#include "runtime/light/sun_position.h"

#include <cmath>

#include <glm/trigonometric.hpp>

namespace cairn {

glm::dvec3 sun_position(double utc_s) {
  const double days = utc_s / 86400 - 10957.5;  // since 2000-01-01 12:00
  const double mean_longitude = 280.460 + 0.9856474 * days;
  const double anomaly = glm::radians(357.528 + 0.9856003 * days);
  const double longitude =
      glm::radians(mean_longitude + 1.915 * std::sin(anomaly) + 0.020 * std::sin(2 * anomaly));
  const double obliquity = glm::radians(23.439 - 0.0000004 * days);
  const double ascension = std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double sine = std::sin(obliquity) * std::sin(longitude);
  const double cosine = std::sqrt(1 - sine * sine);
  // Greenwich's mean sidereal time (Meeus 1998, 12.4), by its whole turns first, as the sum is large.
  const double turned = std::fmod(days, 1.0) * 360 + 0.98564736629 * days;
  const double east = ascension - glm::radians(280.46061837 + turned);
  return {cosine * std::cos(east), cosine * std::sin(east), sine};
}

}  // namespace cairn
