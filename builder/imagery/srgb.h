#pragma once

#include <array>
#include <cstdint>

namespace cairn {

/// Linear light in steps of 1/65535 for each sRGB code (IEC 61966-2-1).
const std::array<float, 256>& linear_of_srgb();

/// The sRGB code for each linear value: the one whose interval of codes, half a code each way, holds it.
const std::array<std::uint8_t, 65536>& srgb_of_linear();

}  // namespace cairn
