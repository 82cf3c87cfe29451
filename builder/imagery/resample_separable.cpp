#include <algorithm>
#include <cmath>

#include "builder/imagery/image_resample.h"
#include "builder/imagery/linear_pixels.h"
#include "builder/imagery/pixel_block.h"
#include "builder/imagery/pixel_taps.h"
#include "builder/imagery/texel_loops.h"

namespace cairn {
namespace {

using std::int64_t;

// Texels first…last of those positions along one axis whose centres lie in the image.
struct Inside {
  int first = 0;
  int count = 0;
};

Inside inside_of(const std::vector<double>& positions, int64_t pixels, bool unbounded) {
  const auto in = [&](double p) {
    return unbounded || (p >= -0.5 && p <= static_cast<double>(pixels) - 0.5);
  };
  const auto first = std::find_if(positions.begin(), positions.end(), in);
  const auto last = std::find_if(positions.rbegin(), positions.rend(), in).base();
  if (first >= last) return {};
  return {static_cast<int>(first - positions.begin()), static_cast<int>(last - first)};
}

void keep(std::vector<double>& positions, Inside inside) {
  positions.erase(positions.begin() + inside.first + inside.count, positions.end());
  positions.erase(positions.begin(), positions.begin() + inside.first);
}

PostWindow pixels_for(const PixelTaps& columns, const PixelTaps& rows) {
  const auto [west, east] = std::minmax_element(columns.first.begin(), columns.first.end());
  const auto [north, south] = std::minmax_element(rows.first.begin(), rows.first.end());
  return {*west, *north, *east - *west + columns.count, *south - *north + rows.count};
}

// Rows of pixels, filtered along the row, kept for as long as texels need them.
class FilteredRows {
 public:
  FilteredRows(const PixelBlock& block, const PixelTaps& columns, int keep)
      : block_(block), columns_(columns), pixels_(static_cast<std::size_t>(block.columns)) {
    rows_.resize(static_cast<std::size_t>(keep));
  }

  const FloatTexel* row(int64_t pixel_row) {
    Row& kept = rows_[static_cast<std::size_t>(pixel_row - block_.row) % rows_.size()];
    if (kept.texels.empty() || kept.pixel_row != pixel_row) {
      to_linear_light(block_.at(block_.column, pixel_row), pixels_);
      kept.pixel_row = pixel_row;
      kept.texels.resize(columns_.first.size());
      texel_loops().filter(pixels_.data(), block_.column, columns_, kept.texels.data());
    }
    return kept.texels.data();
  }

 private:
  struct Row {
    int64_t pixel_row = 0;
    UninitializedVector<FloatTexel> texels;
  };

  const PixelBlock& block_;
  const PixelTaps& columns_;
  UninitializedVector<FloatTexel> pixels_;
  std::vector<Row> rows_;
};

LinearImage filter_block(const PixelBlock& block, const PixelTaps& columns, const PixelTaps& rows) {
  LinearImage image =
      LinearImage::unset(static_cast<int>(columns.first.size()), static_cast<int>(rows.first.size()));
  FilteredRows filtered(block, columns, rows.count);
  std::vector<const FloatTexel*> around(static_cast<std::size_t>(rows.count));
  for (int r = 0; r < image.rows; ++r) {
    const auto at = static_cast<std::size_t>(r);
    for (std::size_t i = 0; i < around.size(); ++i)
      around[i] = filtered.row(rows.first[at] + static_cast<int64_t>(i));
    texel_loops().combine(around, &rows.weights[at * around.size()], columns.first.size(), image.row(r));
  }
  return image;
}

}  // namespace

Result<ResampledImage> resample_separable(const RasterSource& source, const TexelWindow& window, double turn,
                                          bool with_rims) {
  const RasterInfo& info = source.info();
  std::vector<double> xs, ys;
  for (int c = 0; c < window.columns; ++c)
    xs.push_back(info.georeference.post_at({window.lon_of(c) + turn, 0}).column);
  for (int r = 0; r < window.rows; ++r)
    ys.push_back(info.georeference.post_at({0, std::clamp(window.lat_of(r), -90.0, 90.0)}).row);
  const Inside across = inside_of(xs, info.columns, goes_around(info));
  const Inside down = inside_of(ys, info.rows, false);
  ResampledImage image{across.first, down.first, {}, false, {}};
  if (across.count == 0 || down.count == 0) return image;
  keep(xs, across);
  keep(ys, down);

  const PixelTaps columns = taps_along(xs);
  const PixelTaps rows = taps_along(ys);
  const auto block = read_block(source, pixels_for(columns, rows));
  if (!block) return block.error();
  image.texels = filter_block(*block, columns, rows);
  image.is_opaque = is_opaque(*block);
  if (!with_rims) return image;
  for (const double y : ys) {
    for (const double x : xs) image.rims.push_back(static_cast<float>(rim_distance(info, {x, y})));
  }
  return image;
}

}  // namespace cairn
