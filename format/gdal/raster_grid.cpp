#include "format/gdal/raster_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace cairn {
namespace {

constexpr double kFewPixels = 256;  // along a side: no overview of fewer is of use
constexpr double kNearly = 1e-7;    // of a pixel

/// Pixels along an axis, in whole steps from 180 degrees west or 90 degrees south.
struct Span {
  double first = 0;
  double count = 0;
};

/// The samples from the last at or before `from` to the first at or past `to`.
Span samples_between(double from, double to, double step) {
  const double first = std::floor(from / step + kNearly);
  return {first, std::ceil(to / step - kNearly) - first + 1};
}

/// The texels that touch from…to, and as many around them as make both ends a multiple of `multiple`.
Span texels_between(double from, double to, double step, double multiple) {
  const double first = std::floor((from / step + kNearly) / multiple) * multiple;
  const double last = std::ceil((to / step - kNearly) / multiple) * multiple;
  return {first, std::max(multiple, last - first)};
}

/// The coarser grid that covers the area of `full`; of a level that is `halvings` coarser.
RasterGrid overview_of(const RasterGrid& full, int halvings) {
  RasterGrid out = full;
  const double ratio = std::ldexp(1.0, halvings);
  out.columns = static_cast<int>(std::ceil(full.columns / ratio));
  out.rows = static_cast<int>(std::ceil(full.rows / ratio));
  out.column_degrees = full.column_degrees * full.columns / out.columns;
  out.row_degrees = full.row_degrees * full.rows / out.rows;
  out.level = full.level - halvings;
  return out;
}

/// How many halvings make `pixels` few, if the layer has so many levels.
int overview_count(double pixels, int levels) {
  int count = 0;
  while (count < levels && pixels > kFewPixels) {
    pixels = std::ceil(pixels / 2);
    ++count;
  }
  return count;
}

}  // namespace

Result<std::vector<RasterGrid>> raster_grids(const PackReader& pack, Layer layer, const GeoBounds& bounds,
                                             int level) {
  const double step = tile_width_degrees(level) / (pack.header().tile_size - 1);
  const int coarser = level - pack.levels(layer)->coarsest;
  const int overviews = overview_count(std::max(bounds.width(), bounds.height()) / step, coarser);
  const double west = bounds.west + 180, south = bounds.south + 90;
  const double east = west + bounds.width(), north = south + bounds.height();
  const double multiple = std::ldexp(1.0, overviews);
  const bool is_imagery = layer == Layer::imagery;
  const Span across =
      is_imagery ? texels_between(west, east, step, multiple) : samples_between(west, east, step);
  const Span along =
      is_imagery ? texels_between(south, north, step, multiple) : samples_between(south, north, step);
  if (std::max(across.count, along.count) > std::numeric_limits<int>::max()) {
    return bad_data(pack.path().string() + ": " + to_string(layer) + ": level " + std::to_string(level) +
                    ": expected fewer than 2^31 pixels along a side, found " + std::to_string(across.count) +
                    " x " + std::to_string(along.count));
  }
  // A sample is its pixel's centre, a texel reaches from edge to edge.
  const double half = is_imagery ? 0 : 0.5;
  const RasterGrid full{(across.first - half) * step - 180,
                        (along.first + along.count - half) * step - 90,
                        step,
                        step,
                        static_cast<int>(across.count),
                        static_cast<int>(along.count),
                        level};
  std::vector<RasterGrid> grids{full};
  for (int i = 1; i <= overviews; ++i) grids.push_back(overview_of(full, i));
  return grids;
}

}  // namespace cairn
