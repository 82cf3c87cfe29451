#pragma once

#include <cstdint>

namespace cairn {

/// The value that stands for a void where heights are int16.
inline constexpr std::int16_t kVoidMetres = -32768;

/// Rounded to nearest and kept between -32767 and 32767; kVoidMetres for NaN.
std::int16_t whole_metres(double metres);

}  // namespace cairn
