#include "builder/export/tile_edge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "builder/export/rim_grids.h"
#include "builder/export/surface_normal.h"

namespace cairn {
namespace {

/// The share of the bound that an edge may be off its samples. Those of the tiles on both sides differ by
/// their surfaces' errors.
constexpr double kEdgeShare = 0.35;

struct Sample {
  std::int64_t along;
  int level;  // of the tile that it is from
  TileId tile;
  double metres;  // NaN where void
};

struct Line {
  TickRect rect;  // without width or height
  bool upright = false;
  std::int64_t from = 0, to = 0;
};
Line line_of(const GeographicTile& tile, TileSide side) {
  const TickRect r = tile.rect();
  switch (side) {
    case TileSide::west:
      return {{r.west, r.south, r.west, r.north}, true, r.south, r.north};
    case TileSide::east:
      return {{r.east, r.south, r.east, r.north}, true, r.south, r.north};
    case TileSide::south:
      return {{r.west, r.south, r.east, r.south}, false, r.west, r.east};
    case TileSide::north:
      break;
  }
  return {{r.west, r.north, r.east, r.north}, false, r.west, r.east};
}

GeographicTile neighbour(const GeographicTile& tile, TileSide side) {
  GeographicTile other = tile;
  if (side == TileSide::west) other.x -= 1;
  if (side == TileSide::east) other.x += 1;
  if (side == TileSide::south) other.y -= 1;
  if (side == TileSide::north) other.y += 1;
  const std::int64_t around = std::int64_t{2} << tile.level;
  other.x = (other.x + around) % around;
  return other;
}

class EdgeMaker {
 public:
  EdgeMaker(const QuantizedMeshSource& source, const GeographicTile& tile, TileSide side)
      : source_(source), level_(tile.level), line_(line_of(tile, side)) {
    bound_m_ = source.plan.bound_m(tile);
    const GeographicTile other = neighbour(tile, side);
    const bool in_world = other.y >= 0 && other.y < std::int64_t{1} << tile.level;
    if (in_world && source.plan.has(other)) bound_m_ = std::min(bound_m_, source.plan.bound_m(other));
  }

  Result<TileEdge> make() {
    for (const std::int64_t end : {line_.from, line_.to}) {
      const auto height = corner(end);
      if (!height) return height.error();
      (end == line_.from ? first_ : last_) = *height;
    }
    // A pole is one place.
    const std::int64_t y = line_.rect.south;
    if (!line_.upright && (y == 0 || y == kTicksPoleToPole))
      return TileEdge{{{line_.from, first_}, {line_.to, last_}}, 0};
    if (auto status = collect(line_.rect); !status) return status.error();
    if (line_.upright && line_.rect.west % kTicksAround == 0) {
      TickRect other = line_.rect;
      other.west = other.east = kTicksAround - line_.rect.west;
      if (auto status = collect(other); !status) return status.error();
    }
    add_uncovered();
    return simplify();
  }

 private:
  LonLat place(std::int64_t along) const {
    return line_.upright ? place_of(line_.rect.west % kTicksAround, along)
                         : place_of(along, line_.rect.south);
  }
  double rounded(double metres) const { return rounded_height(source_, metres, level_); }

  /// The height of a corner depends on the corner alone.
  Result<double> corner(std::int64_t along) const {
    std::int64_t x = line_.upright ? line_.rect.west : along;
    const std::int64_t y = line_.upright ? along : line_.rect.south;
    if (x == kTicksAround || y == 0 || y == kTicksPoleToPole) x = 0;
    int level = source_.patches.coarsest();
    while (source_.plan.order_of(level, level_) < 0 && level < source_.patches.finest()) ++level;
    const auto height = pack_height(source_.patches, source_.tiles, x, y, level);
    if (!height) return height.error();
    double metres = *height;
    if (std::isnan(metres)) {
      const auto around = height_around(x, y);
      if (!around) return around.error();
      metres = *around;
    }
    return rounded(metres + source_.shift.at(place_of(x, y)));
  }

  /// The mean of the finest samples around a void corner, so that the surface goes on beyond the rim of the
  /// ground; 0 where there are none.
  Result<double> height_around(std::int64_t x, std::int64_t y) const {
    const auto found = source_.patches.tile_at(x, y, kMaxLevel);
    if (!found || y == 0 || y == kTicksPoleToPole) return 0.0;
    const std::int64_t step = tile_ticks(found->entry.id.level) >> source_.plan.interval_bits();
    double sum = 0;
    int count = 0;
    for (const std::int64_t dx : {-step, std::int64_t{0}, step})
      for (const std::int64_t dy : {-step, std::int64_t{0}, step}) {
        const auto height =
            pack_height(source_.patches, source_.tiles, (x + dx + kTicksAround) % kTicksAround,
                        std::clamp<std::int64_t>(y + dy, 0, kTicksPoleToPole), kMaxLevel);
        if (!height) return height.error();
        if (std::isnan(*height)) continue;
        sum += *height;
        ++count;
      }
    return count == 0 ? 0.0 : sum / count;
  }

  Status collect(const TickRect& rect) {
    const double wanted = kSurfaceShare * bound_m_;
    int finest = source_.patches.coarsest();
    while (source_.plan.order_of(finest, level_) < kMostOrder && finest < kMaxLevel) ++finest;
    for (const Patch& patch : source_.patches.over(rect, wanted, finest)) {
      const PatchLattice lattice = lattice_of(source_, patch, level_, wanted);
      surface_error_m_ = std::max(surface_error_m_, lattice.error_m);
      if (auto status = add_samples(rect, patch, lattice.order); !status) return status;
      if ((patch.entry.flags & kHasVoids) == 0) continue;
      // Posts may lie where this patch has no surface.
      TickRect part = rect;
      (line_.upright ? part.south : part.west) =
          std::max(line_.from, line_.upright ? patch.area.south : patch.area.west);
      (line_.upright ? part.north : part.east) =
          std::min(line_.to, line_.upright ? patch.area.north : patch.area.east);
      for (const Patch& fine : source_.patches.over_rims(part)) {
        const int order = source_.plan.order_of(fine.entry.id.level, level_);
        if (auto status = add_samples(rect, fine, std::clamp(order, 0, kRimOrder)); !status) return status;
      }
    }
    return {};
  }

  Status add_samples(const TickRect& rect, const Patch& patch, int order) {
    const auto tile = source_.tiles.read(patch.entry);
    if (!tile) return tile.error();
    order_ = std::max(order_, order);
    const std::int64_t step = lattice_step(level_, order);
    const std::int64_t low = std::max(line_.from, line_.upright ? patch.area.south : patch.area.west);
    const std::int64_t high = std::min(line_.to, line_.upright ? patch.area.north : patch.area.east);
    for (std::int64_t at = (low + step - 1) / step * step; at <= high; at += step) {
      const double metres =
          line_.upright ? (*tile)->height_at(rect.west, at) : (*tile)->height_at(at, rect.south);
      samples_.push_back({at, patch.entry.id.level, patch.entry.id, metres});
    }
    return {};
  }

  void add_uncovered() {
    const std::int64_t step = lattice_step(level_, 0);
    for (std::int64_t at = line_.from; at <= line_.to; at += step)
      samples_.push_back({at, kMinLevel - 1, {}, std::numeric_limits<double>::quiet_NaN()});
    std::sort(samples_.begin(), samples_.end(), [](const Sample& a, const Sample& b) {
      return std::tuple(a.along, std::isnan(a.metres), -a.level, a.tile) <
             std::tuple(b.along, std::isnan(b.metres), -b.level, b.tile);
    });
    samples_.erase(std::unique(samples_.begin(), samples_.end(),
                               [](const Sample& a, const Sample& b) { return a.along == b.along; }),
                   samples_.end());
    extend_ground();
    for (Sample& s : samples_) s.metres += source_.shift.at(place(s.along));
    samples_.front().metres = first_;
    samples_.back().metres = last_;
  }

  /// A void beside ground gets its height, others 0.
  void extend_ground() {
    std::vector<double> extended;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      double metres = samples_[i].metres;
      if (std::isnan(metres) && i > 0) metres = samples_[i - 1].metres;
      if (std::isnan(metres) && i + 1 < samples_.size()) metres = samples_[i + 1].metres;
      extended.push_back(std::isnan(metres) ? 0 : metres);
    }
    for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].metres = extended[i];
  }

  // Douglas & Peucker 1973, by vertical distance.
  TileEdge simplify() {
    TileEdge edge;
    edge.order = order_;
    const std::int64_t square =
        (line_.to - line_.from) / base_squares(level_, bound_m_, source_.patches.ellipsoid());
    std::size_t before = 0;
    edge.vertices.push_back({samples_[0].along, rounded(samples_[0].metres)});
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      if ((samples_[i].along - line_.from) % square != 0) continue;
      split(before, i, edge);
      before = i;
    }
    return edge;
  }

  double tolerance() const {
    const bool is_usual = surface_error_m_ <= kSurfaceShare * bound_m_;
    return is_usual ? kEdgeShare * bound_m_ : std::max(0.0, (bound_m_ - surface_error_m_) / 4);
  }

  void split(std::size_t low, std::size_t high, TileEdge& edge) {
    const double from = rounded(samples_[low].metres), to = rounded(samples_[high].metres);
    const auto width = static_cast<double>(samples_[high].along - samples_[low].along);
    double worst = tolerance();
    std::size_t at = low;
    for (std::size_t i = low + 1; i < high; ++i) {
      const double t = static_cast<double>(samples_[i].along - samples_[low].along) / width;
      const double off = std::abs(samples_[i].metres - (from + t * (to - from)));
      if (off <= worst) continue;
      worst = off;
      at = i;
    }
    if (at == low) {
      edge.vertices.push_back({samples_[high].along, to});
      return;
    }
    split(low, at, edge);
    split(at, high, edge);
  }

  const QuantizedMeshSource& source_;
  int level_;
  Line line_;
  double bound_m_ = 0;
  double surface_error_m_ = 0;
  double first_ = 0, last_ = 0;
  int order_ = 0;
  std::vector<Sample> samples_;
};

}  // namespace

Result<TileEdge> tile_edge(const QuantizedMeshSource& source, const GeographicTile& tile, TileSide side) {
  return EdgeMaker(source, tile, side).make();
}

PatchLattice lattice_of(const QuantizedMeshSource& source, const Patch& patch, int level, double wanted_m) {
  const int own = source.plan.order_of(patch.entry.id.level, level);
  const double range = source.patches.range_of(patch.entry);
  // At least two intervals a tile: a surface between samples of the tile stays in its range.
  const int least = std::clamp(own - source.plan.interval_bits() + 1, 0, kMostOrder);
  const bool is_flat = patch.error_m + range <= wanted_m;
  const int order = std::max(least, std::clamp(own, 0, is_flat ? 1 : kMostOrder));
  return {order, patch.error_m + (order < own ? range : 0)};
}

int base_squares(int level, double bound_m, const Ellipsoid& ellipsoid) {
  constexpr double kDiagonal = 4.44;  // of a tile of level 0 at the equator, in radii: √2·π
  const double longest = std::sqrt(kSurfaceShare * bound_m * 6 * ellipsoid.semi_major_m);  // see sagitta_m()
  const double wanted = std::ldexp(kDiagonal * ellipsoid.semi_major_m, -level) / longest;
  for (const int squares : {1, 3, 5, 9, 15})
    if (squares >= wanted * 0.9) return squares;
  return 45;
}

double rounded_height(const QuantizedMeshSource& source, double metres, int level) {
  const double step = source.plan.height_step_m(level);
  return std::round(metres / step) * step;
}

}  // namespace cairn
