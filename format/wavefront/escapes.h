#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "format/wavefront/geometry.h"

namespace cairn::wavefront {

/// A value that is no symbol of its context, and when the decoder meets it.
struct Escape {
  int step;
  int lane;
  std::uint16_t zigzagged;
};

inline Escape escape_at(const Geometry& g, int row, int column, std::uint16_t zigzagged) {
  const int lane = (row - 1) % kLanes;
  return {(row - 1) / kLanes * g.width + kLeft + column + kSkew * lane, lane, zigzagged};
}

inline std::vector<std::uint16_t> in_order(std::vector<Escape>& escapes) {
  std::sort(escapes.begin(), escapes.end(), [](const Escape& a, const Escape& b) {
    return a.step != b.step ? a.step < b.step : a.lane < b.lane;
  });
  std::vector<std::uint16_t> values;
  values.reserve(escapes.size());
  for (const Escape& escape : escapes) values.push_back(escape.zigzagged);
  return values;
}

}  // namespace cairn::wavefront
