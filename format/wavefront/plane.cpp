#include "format/wavefront/plane.h"

#include <algorithm>

#include "format/wavefront/avx2.h"

namespace cairn::wavefront {

namespace {

inline __attribute__((always_inline)) Range find_range(std::span<const std::int32_t> samples) {
  std::int32_t low = samples[0];
  std::int32_t high = samples[0];
  for (const std::int32_t s : samples) {
    low = s < low ? s : low;
    high = s > high ? s : high;
  }
  return {low, high};
}

#if defined(__x86_64__)
CAIRN_AVX2 Range range_avx2(std::span<const std::int32_t> samples) {
  return find_range(samples);
}
#endif

}  // namespace

Range range_of(std::span<const std::int32_t> samples) {
#if defined(__x86_64__)
  if (cpu_has_avx2()) return range_avx2(samples);
#endif
  return find_range(samples);
}

void pad_first_rows(const Geometry& g, Plane& plane) {
  std::int16_t* row = plane.data() + g.row_start(0);
  std::fill(row, row + kLeft, row[kLeft]);
  std::fill(row + kLeft + g.size, row + g.width, row[kLeft + g.size - 1]);
  std::copy(row, row + g.width, plane.data() + g.row_start(-1));
}

Plane make_plane(const Geometry& g, std::span<const std::int32_t> samples, std::int32_t base) {
  Plane plane(g.plane_area());
  const auto size = static_cast<std::size_t>(g.size);
  for (std::size_t row = 0; row < size; ++row) {
    std::int16_t* to = plane.data() + g.row_start(static_cast<int>(row)) + kLeft;
    for (std::size_t i = 0; i < size; ++i) {
      to[i] = to_base(samples[row * size + i], base);
    }
    if (row == 0) {
      pad_first_rows(g, plane);
    } else {
      pad_row(g, plane, static_cast<int>(row));
    }
  }
  return plane;
}

}  // namespace cairn::wavefront
