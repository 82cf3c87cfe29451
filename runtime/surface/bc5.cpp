#include "runtime/surface/bc5.h"

#include <algorithm>
#include <cassert>

namespace cairn {
namespace {

using Channel = std::array<std::int8_t, 16>;

/// The code of weight w/7 from the first to the second end point, first > second: 0 and 1 are the end points
/// themselves, 2…7 lie between them.
std::uint64_t code_of_weight(int w) {
  return w == 0 ? 0u : w == 7 ? 1u : static_cast<std::uint64_t>(w) + 1;
}

void append_channel(const Channel& values, std::vector<std::byte>& out) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const int range = *high - *low;
  std::uint64_t block =
      static_cast<std::uint8_t>(*high) | static_cast<std::uint64_t>(static_cast<std::uint8_t>(*low)) << 8;
  if (range > 0) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int w = ((*high - values[i]) * 14 + range) / (2 * range);
      block |= code_of_weight(w) << (16 + 3 * i);
    }
  }
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<std::byte>(block >> (8 * i) & 255));
}

}  // namespace

void append_bc5(std::span<const SignedPair> texels, int size, std::vector<std::byte>& out) {
  assert(size % 4 == 0 && texels.size() == static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  Channel x{}, y{};
  for (int row = 0; row < size; row += 4) {
    for (int column = 0; column < size; column += 4) {
      for (int i = 0; i < 16; ++i) {
        const auto at = static_cast<std::size_t>(row + i / 4) * static_cast<std::size_t>(size) +
                        static_cast<std::size_t>(column + i % 4);
        x[static_cast<std::size_t>(i)] = texels[at].x;
        y[static_cast<std::size_t>(i)] = texels[at].y;
      }
      append_channel(x, out);
      append_channel(y, out);
    }
  }
}

}  // namespace cairn
