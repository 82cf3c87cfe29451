#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn::gl {

/// An RGB picture in sRGB, 8 bits a channel, rows from top to bottom.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  const std::uint8_t* pixel(int column, int row) const {
    return &rgb[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(column))];
  }
};

}  // namespace cairn::gl
