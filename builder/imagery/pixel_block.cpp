#include "builder/imagery/pixel_block.h"

#include <algorithm>
#include <cassert>
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
  for (std::int64_t c = 0; c < first; ++c) std::memcpy(row + 4 * c, row + 4 * first, 4);
  for (std::int64_t c = last + 1; c < columns; ++c) std::memcpy(row + 4 * c, row + 4 * last, 4);
}

// Reads a run's rows first…last of the raster into the block.
Status read_run(const RasterSource& source, const Run& run, std::int64_t first, std::int64_t last,
                PixelBlock& block) {
  const PostWindow window{run.from, first, run.count, last - first + 1};
  const auto bytes = static_cast<std::size_t>(4 * window.columns * window.rows);
  std::uint8_t* to = block.rgba.data() + 4 * ((first - block.row) * block.columns + run.to);
  if (run.count == block.columns) return source.read_colours(window, {to, bytes});
  std::vector<std::uint8_t> piece(bytes);
  if (auto status = source.read_colours(window, piece); !status) return status;
  const auto row_bytes = static_cast<std::size_t>(4 * run.count);
  for (std::int64_t r = 0; r < window.rows; ++r)
    std::memcpy(to + 4 * r * block.columns, piece.data() + static_cast<std::size_t>(r) * row_bytes,
                row_bytes);
  return {};
}

}  // namespace

// Without a way out of the loop, which then is a wide one.
bool is_opaque(const PixelBlock& block) {
  std::uint32_t all = ~0U;
  for (std::size_t i = 0; i < block.rgba.size(); i += 4) {
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, &block.rgba[i], sizeof pixel);
    all &= pixel;
  }
  return all >> 24 == 255;
}

bool goes_around(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  const bool degrees = g.crs == Georeference::Crs::geographic && g.is_straight();
  return degrees && std::abs(static_cast<double>(info.columns) * g.dx - 360) < g.dx / 2;
}

Result<PixelBlock> read_block(const RasterSource& source, const PostWindow& window) {
  const RasterInfo& info = source.info();
  PixelBlock block{window.column, window.row, window.columns, window.rows, {}};
  block.rgba.resize(static_cast<std::size_t>(4 * window.columns * window.rows));
  const std::int64_t first = std::max<std::int64_t>(window.row, 0);
  const std::int64_t last = std::min(window.row + window.rows, info.rows) - 1;
  assert(first <= last);
  const std::vector<Run> runs = runs_of(info, window);
  for (const Run& run : runs) {
    if (auto status = read_run(source, run, first, last, block); !status) return status.error();
  }
  const auto row_at = [&](std::int64_t r) {
    return block.rgba.data() + 4 * (r - window.row) * window.columns;
  };
  const std::int64_t west = runs.front().to, east = runs.back().to + runs.back().count - 1;
  for (std::int64_t r = first; r <= last; ++r) extend_row(row_at(r), west, east, window.columns);
  const auto row_bytes = static_cast<std::size_t>(4 * window.columns);
  for (std::int64_t r = window.row; r < window.row + window.rows; ++r) {
    if (r < first || r > last) std::memcpy(row_at(r), row_at(r < first ? first : last), row_bytes);
  }
  return block;
}

}  // namespace cairn
