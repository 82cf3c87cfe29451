#include "format/tile_edges.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "format/checksum.h"

namespace cairn {
namespace {

/// Columns and rows of a tile, `step` apart.
struct Grid {
  int first_column, first_row, columns, rows, step;
};

std::int64_t sample(const HeightTile& tile, int column, int row) {
  return tile.is_void(column, row) ? kVoidSample : tile.at(column, row);
}

std::vector<std::int64_t> samples_of(const HeightTile& tile, const Grid& grid) {
  std::vector<std::int64_t> out(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
  std::size_t at = 0;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      out[at++] = sample(tile, grid.first_column + c * grid.step, grid.first_row + r * grid.step);
    }
  }
  return out;
}

std::uint64_t digest(const std::vector<std::int64_t>& samples) {
  return checksum(std::as_bytes(std::span(samples)));
}

int last_inside(double world_end, double tile_start, double width, int tile_size) {
  // Exact: both ends are multiples of 2^-level, and 360·512 and 180·256 hold 2^9 and more.
  const double intervals = (world_end - tile_start) / width * (tile_size - 1);
  return static_cast<int>(std::min(intervals, static_cast<double>(tile_size - 1)));
}

}  // namespace

WorldExtent world_extent(const TileId& id, int tile_size) {
  const GeoBounds bounds = tile_bounds(id);
  return {last_inside(180, bounds.west, bounds.width(), tile_size),
          last_inside(90, bounds.south, bounds.height(), tile_size)};
}

std::vector<std::int64_t> edge_samples(const HeightTile& tile, const TileId& id, Edge edge) {
  const int last = tile.size - 1;
  switch (edge) {
    case Edge::west:
      return samples_of(tile, {0, 0, 1, tile.size, 1});
    case Edge::east:
      return samples_of(tile, {world_extent(id, tile.size).east, 0, 1, tile.size, 1});
    case Edge::south:
      return samples_of(tile, {0, 0, tile.size, 1, 1});
    case Edge::north:
      break;
  }
  return samples_of(tile, {0, last, tile.size, 1, 1});
}

std::vector<std::int64_t> quadrant_samples(const HeightTile& tile, int quadrant) {
  assert(quadrant >= 0 && quadrant < 4);
  const int half = tile.size / 2;
  return samples_of(tile, {(quadrant & 1) * half, (quadrant >> 1) * half, half + 1, half + 1, 1});
}

std::vector<std::int64_t> even_samples(const HeightTile& tile) {
  const int count = tile.size / 2 + 1;
  return samples_of(tile, {0, 0, count, count, 2});
}

TileDigest digest_of(const HeightTile& tile, const TileId& id) {
  const int last = tile.size - 1;
  const int east = world_extent(id, tile.size).east;
  TileDigest d;
  d.west = digest(edge_samples(tile, id, Edge::west));
  d.east = digest(edge_samples(tile, id, Edge::east));
  d.south = digest(edge_samples(tile, id, Edge::south));
  d.north = digest(edge_samples(tile, id, Edge::north));
  d.south_west = sample(tile, 0, 0);
  d.south_east = sample(tile, east, 0);
  d.north_west = sample(tile, 0, last);
  d.north_east = sample(tile, east, last);
  for (int q = 0; q < 4; ++q) d.quadrants[static_cast<std::size_t>(q)] = digest(quadrant_samples(tile, q));
  d.even = digest(even_samples(tile));
  return d;
}

}  // namespace cairn
