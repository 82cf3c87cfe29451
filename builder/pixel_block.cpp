#include "builder/pixel_block.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cairn {
namespace {

std::int64_t wrapped(std::int64_t column, std::int64_t columns) {
  return (column % columns + columns) % columns;
}

// Columns that lie side by side in the raster too.
struct Run {
  std::int64_t to = 0;  // in the block
  std::int64_t from = 0;
  std::int64_t count = 0;
};

std::vector<Run> runs_of(const RasterInfo& info, const PostWindow& window) {
  std::vector<Run> runs;
  if (!goes_around(info)) {
    const std::int64_t west = std::clamp<std::int64_t>(window.column, 0, info.columns - 1);
    const std::int64_t east =
        std::clamp<std::int64_t>(window.column + window.columns - 1, 0, info.columns - 1);
    return {{west - window.column, west, east - west + 1}};
  }
  for (std::int64_t c = 0; c < window.columns;) {
    const std::int64_t from = wrapped(window.column + c, info.columns);
    const std::int64_t count = std::min(info.columns - from, window.columns - c);
    runs.push_back({c, from, count});
    c += count;
  }
  return runs;
}

// The border pixels go on to the block's ends. What was read is columns first…last.
void extend_row(std::uint8_t* row, std::int64_t first, std::int64_t last, std::int64_t columns) {
  for (std::int64_t c = 0; c < std::min(first, columns); ++c) {
    if (first < columns) std::memcpy(row + 4 * c, row + 4 * first, 4);
  }
  for (std::int64_t c = std::max<std::int64_t>(last + 1, 0); c < columns; ++c) {
    if (last >= 0) std::memcpy(row + 4 * c, row + 4 * last, 4);
  }
}

}  // namespace

bool goes_around(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  const bool degrees = g.crs == Georeference::Crs::geographic;
  return degrees && std::abs(static_cast<double>(info.columns) * g.dx - 360) < g.dx / 2;
}

Result<PixelBlock> read_block(const RasterSource& source, const PostWindow& window) {
  const RasterInfo& info = source.info();
  PixelBlock block{window.column, window.row, window.columns, window.rows, {}};
  block.rgba.resize(static_cast<std::size_t>(4 * window.columns * window.rows));
  const std::int64_t north = std::clamp<std::int64_t>(window.row, 0, info.rows - 1);
  const std::int64_t south = std::clamp<std::int64_t>(window.row + window.rows - 1, 0, info.rows - 1);
  const auto row_at = [&](std::int64_t r) {
    return block.rgba.data() + 4 * (r - window.row) * window.columns;
  };

  std::vector<std::uint8_t> piece;
  const std::vector<Run> runs = runs_of(info, window);
  for (const Run& run : runs) {
    piece.resize(static_cast<std::size_t>(4 * run.count * (south - north + 1)));
    if (auto status = source.read_colours({run.from, north, run.count, south - north + 1}, piece); !status)
      return status.error();
    const std::int64_t skip = std::max<std::int64_t>(0, -run.to);
    const std::int64_t count = std::min(run.to + run.count, window.columns) - (run.to + skip);
    if (count <= 0) continue;
    for (std::int64_t r = std::max(north, window.row); r <= std::min(south, window.row + window.rows - 1);
         ++r)
      std::memcpy(row_at(r) + 4 * (run.to + skip), piece.data() + 4 * ((r - north) * run.count + skip),
                  static_cast<std::size_t>(4 * count));
  }
  const std::int64_t first = runs.front().to, last = runs.back().to + runs.back().count - 1;
  for (std::int64_t r = std::max(north, window.row); r <= std::min(south, window.row + window.rows - 1); ++r)
    extend_row(row_at(r), first, last, window.columns);
  const auto row_bytes = static_cast<std::size_t>(4 * window.columns);
  for (std::int64_t r = window.row; r < window.row + window.rows; ++r) {
    if (r < north || r > south) std::memcpy(row_at(r), row_at(r < north ? north : south), row_bytes);
  }
  return block;
}

}  // namespace cairn
