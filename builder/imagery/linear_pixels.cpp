#include "builder/imagery/linear_pixels.h"

#include <algorithm>
#include <cmath>

#include "builder/imagery/pixel_block.h"
#include "builder/imagery/srgb.h"

namespace cairn {

void to_linear_light(const std::uint8_t* rgba, std::span<FloatTexel> pixels) {
  const auto& linear = linear_of_srgb();
  for (FloatTexel& pixel : pixels) {
    const FloatTexel colour{linear[rgba[0]], linear[rgba[1]], linear[rgba[2]], 65535.0F};
    pixel = rgba[3] == 255 ? colour : colour * (static_cast<float>(rgba[3]) / 255.0F);
    rgba += 4;
  }
}

double rim_distance(const RasterInfo& info, PlanePoint position) {
  const double columns = static_cast<double>(info.columns), rows = static_cast<double>(info.rows);
  const double across = goes_around(info) ? HUGE_VAL : std::min(position.x + 0.5, columns - 0.5 - position.x);
  return std::min({across, position.y + 0.5, rows - 0.5 - position.y});
}

}  // namespace cairn
