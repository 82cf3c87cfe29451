#include "builder/export/whole_metres.h"

#include <algorithm>
#include <cmath>

namespace cairn {

std::int16_t whole_metres(double metres) {
  if (std::isnan(metres)) return kVoidMetres;
  return static_cast<std::int16_t>(std::clamp(std::floor(metres + 0.5), -32767.0, 32767.0));
}

}  // namespace cairn
