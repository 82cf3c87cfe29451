#include "format/ground_sampler.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "format/tile_edges.h"

namespace cairn {
namespace {

/// Where a place lies in a tile, in sample intervals from its south-west corner.
struct TilePlace {
  TileId id;
  double column = 0;
  double row = 0;
};

/// A position that is a sample's but for the arithmetic becomes it exactly, so that a place on an edge is
/// found on the edge and a neighbouring void does not swallow it. A millionth of an interval, but no less
/// than what a longitude in double precision can lose.
double snap(double position, double intervals_per_degree) {
  const double slack = std::max(1e-6, 1e-13 * intervals_per_degree);
  const double nearest = std::round(position);
  return std::abs(position - nearest) <= slack ? nearest : position;
}

/// REQUIRES: the tile holds the place, to within rounding; the longitude may be off by turns of the Earth.
TilePlace place_in(const TileId& id, LonLat place, int intervals) {
  const GeoBounds bounds = tile_bounds(id);
  const double scale = intervals / bounds.width();
  double east = std::fmod(place.lon - bounds.west, 360.0);
  if (east < -1e-9) east += 360.0;
  if (east > 360.0 - 1e-9) east -= 360.0;
  const auto inside = [intervals](double at) { return std::clamp(at, 0.0, static_cast<double>(intervals)); };
  return {id, inside(snap(east * scale, scale)), inside(snap((place.lat - bounds.south) * scale, scale))};
}

/// The tile that holds the place, then the neighbours that share it on an edge or a corner: where the pack
/// lacks the first, another may be there.
struct Candidates {
  std::array<TilePlace, 4> places;
  std::size_t count = 0;
};

Candidates candidates_at(LonLat place, int level, int intervals) {
  const TilePlace first = place_in(tile_at(place, level), place, intervals);
  const WorldExtent extent = world_extent(first.id, intervals + 1);
  const auto step = [](double at, int last) { return at == 0 ? -1 : at >= last ? 1 : 0; };
  const int dx = step(first.column, extent.east);
  const int dy = step(first.row, extent.north);
  Candidates out;
  out.places[out.count++] = first;
  const auto add = [&](int x, int y) {
    const TileId id = neighbour_of(first.id, x, y);
    if (is_valid(id)) out.places[out.count++] = place_in(id, place, intervals);
  };
  if (dx != 0) add(dx, 0);
  if (dy != 0) add(0, dy);
  if (dx != 0 && dy != 0) add(dx, dy);
  return out;
}

/// Bilinear, in quanta; nullopt where a sample with weight is void.
std::optional<double> interpolate(const HeightTile& tile, const TilePlace& place) {
  const int column = std::min(static_cast<int>(place.column), tile.size - 2);
  const int row = std::min(static_cast<int>(place.row), tile.size - 2);
  const double t = place.column - column;
  const double u = place.row - row;
  const double weights[2][2] = {{(1 - t) * (1 - u), t * (1 - u)}, {(1 - t) * u, t * u}};
  double sum = 0;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 2; ++c) {
      if (weights[r][c] == 0) continue;
      if (tile.is_void(column + c, row + r)) return std::nullopt;
      sum += weights[r][c] * tile.at(column + c, row + r);
    }
  }
  return sum;
}

/// Whether the place lies in a tile, not on its edge.
bool is_inside(const TilePlace& place, const WorldExtent& extent) {
  return place.column > 0 && place.column < extent.east && place.row > 0 && place.row < extent.north;
}

}  // namespace

struct GroundSampler::State {
  struct Cached {
    TileId id;
    HeightTile tile;
  };

  /// What the last place inside a tile of the grid, not on its edge, led to: the tile that gives the heights
  /// is one for all places there. It is the first of the cache.
  struct Asked {
    TileId id;
    WorldExtent extent;  // of id
    int coarsest = 0;
    std::optional<IndexEntry> found;
  };

  Result<const HeightTile*> tile(const IndexEntry& entry);
  Result<std::optional<IndexEntry>> find_tile(LonLat place, int finest, int coarsest, TilePlace& at);

  GroundTiles tiles;
  std::size_t most_tiles;
  std::vector<Cached> cache;  // latest use first
  std::optional<Asked> asked;
};

Result<const HeightTile*> GroundSampler::State::tile(const IndexEntry& entry) {
  const auto hit =
      std::find_if(cache.begin(), cache.end(), [&](const Cached& cached) { return cached.id == entry.id; });
  if (hit != cache.end()) {
    std::rotate(cache.begin(), hit, hit + 1);
    return &cache.front().tile;
  }
  Result<HeightTile> read = tiles.read(entry);
  if (!read) return read.error();
  if (cache.size() == most_tiles) cache.pop_back();
  cache.insert(cache.begin(), Cached{entry.id, std::move(*read)});
  return &cache.front().tile;
}

/// Returns the tile that gives the height, now the first of the cache, and in `at` where the place lies in
/// it.
Result<std::optional<IndexEntry>> GroundSampler::State::find_tile(LonLat place, int finest, int coarsest,
                                                                  TilePlace& at) {
  const int intervals = tiles.tile_size - 1;
  if (asked && asked->id.level == finest && asked->coarsest == coarsest) {
    at = place_in(asked->id, place, intervals);  // on an edge where it lies outside
    if (is_inside(at, asked->extent)) {
      if (asked->found && asked->found->id != asked->id) at = place_in(asked->found->id, place, intervals);
      return asked->found;
    }
  }
  asked.reset();
  std::optional<IndexEntry> found;
  for (int l = finest; l >= coarsest && !found; --l) {
    const Candidates candidates = candidates_at(place, l, intervals);
    for (std::size_t i = 0; i < candidates.count && !found; ++i) {
      at = candidates.places[i];
      found = tiles.find(at.id);
    }
  }
  if (found) {
    if (const auto read = tile(*found); !read) return read.error();
  }
  const TileId first = tile_at(place, finest);
  const WorldExtent extent = world_extent(first, intervals + 1);
  if (is_inside(place_in(first, place, intervals), extent)) asked = Asked{first, extent, coarsest, found};
  return found;
}

GroundSampler::GroundSampler(GroundTiles tiles, std::size_t cached_tiles)
    : state_(new State{std::move(tiles), cached_tiles, {}, {}}) {
  assert(cached_tiles >= 1);
}

GroundSampler::~GroundSampler() = default;
GroundSampler::GroundSampler(GroundSampler&&) noexcept = default;

Result<std::optional<GroundSampler::Height>> GroundSampler::height_at(LonLat place, int finest,
                                                                      int coarsest) {
  using Answer = std::optional<Height>;
  TilePlace at;
  const auto entry = state_->find_tile(place, finest, coarsest, at);
  if (!entry) return entry.error();
  if (!*entry) return Answer();
  const std::optional<double> quanta = interpolate(state_->cache.front().tile, at);
  if (!quanta) return Answer();
  return Answer(Height{*quanta, **entry});
}

}  // namespace cairn
