#include "builder/imagery/srgb.h"

#include <cmath>
#include <cstddef>

namespace cairn {
namespace {

constexpr double kOne = 65535;

double to_linear(double code) {
  const double v = code / 255;
  return kOne * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

}  // namespace

const std::array<float, 256>& linear_of_srgb() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t code = 0; code < values.size(); ++code)
      values[code] = static_cast<float>(to_linear(static_cast<double>(code)));
    return values;
  }();
  return table;
}

const std::array<std::uint8_t, 65536>& srgb_of_linear() {
  static const auto table = [] {
    std::array<std::uint8_t, 65536> codes{};
    std::size_t linear = 0;
    for (int code = 0; code < 256; ++code) {
      const double end = code == 255 ? kOne + 1 : to_linear(code + 0.5);
      for (; linear < codes.size() && static_cast<double>(linear) < end; ++linear)
        codes[linear] = static_cast<std::uint8_t>(code);
    }
    return codes;
  }();
  return table;
}

}  // namespace cairn
