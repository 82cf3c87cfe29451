#pragma once

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

namespace cairn::gl {

/// Returns linear RGB, 0 to 1, of 0xRRGGBB in sRGB (IEC 61966-2-1).
inline glm::vec3 linear_of(std::uint32_t srgb) {
  const auto linear = [srgb](int shift) {
    const float c = static_cast<float>(srgb >> shift & 255u) / 255.0f;
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  return {linear(16), linear(8), linear(0)};
}

}  // namespace cairn::gl
