#include "builder/raster/whole_metre_probe.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace cairn {
namespace {

constexpr std::int64_t kWindows = 5;        // along each axis
constexpr std::int64_t kSide = 16;          // posts along a window
constexpr std::size_t kLeastDifferent = 8;  // heights

// The first post of a window, of those that lie evenly from edge to edge.
std::int64_t first_post(std::int64_t window, std::int64_t posts, std::int64_t side) {
  return (posts - side) * window / (kWindows - 1);
}

}  // namespace

bool seems_whole_metres(const RasterSource& raster) {
  const std::int64_t columns = std::min(kSide, raster.info().columns);
  const std::int64_t rows = std::min(kSide, raster.info().rows);
  std::vector<float> heights(static_cast<std::size_t>(columns * rows));
  std::set<float> different;
  for (std::int64_t window = 0; window < kWindows * kWindows; ++window) {
    const PostWindow posts{first_post(window % kWindows, raster.info().columns, columns),
                           first_post(window / kWindows, raster.info().rows, rows), columns, rows};
    if (!raster.read_heights(posts, heights)) return false;
    for (const float height : heights) {
      if (std::isnan(height)) continue;
      if (height != std::floor(height)) return false;
      if (different.size() < kLeastDifferent) different.insert(height);
    }
  }
  return different.size() >= kLeastDifferent;
}

}  // namespace cairn
