#include "format/wavefront/plane.h"

#include <algorithm>

namespace cairn::wavefront {

void pad_first_rows(const Geometry& g, Plane& plane) {
  std::int16_t* row = plane.data() + g.row_start(0);
  std::fill(row, row + kLeft, row[kLeft]);
  std::fill(row + kLeft + g.size, row + g.width, row[kLeft + g.size - 1]);
  std::copy(row, row + g.width, plane.data() + g.row_start(-1));
}

}  // namespace cairn::wavefront
