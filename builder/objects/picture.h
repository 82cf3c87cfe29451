#pragma once

#include <cstdint>
#include <vector>

#include "cairn/bake_choices.h"
#include "cairn/texture_tile.h"

namespace cairn {

/// An image in sRGB with straight alpha, rows from above.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;

  static Picture filled(int width, int height, const std::uint8_t (&colour)[4]);
  const std::uint8_t* at(int x, int y) const { return &rgba[index(x, y)]; }
  std::uint8_t* at(int x, int y) { return &rgba[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

/// Returns the picture at another size: each texel is the mean of what it covers, in linear light.
Picture resized(const Picture& picture, int width, int height);

/// Returns the largest power of 2 that is at most `size`, within the limits, which are powers of 2.
int power_of_two_within(int size, int least, int most);

/// Returns a square picture as blocks with all mips. Transparent texels have the colour of the next mip. BC1
/// becomes BC3 where a texel is not opaque. REQUIRES: a width that is a power of 2, and equal to the height.
TextureTile texture_of(const Picture& picture, TextureFormat format);

}  // namespace cairn
