#include "builder/export/pack_patches.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

namespace cairn {
namespace {

bool spans(std::int64_t low, std::int64_t high, std::int64_t from, std::int64_t to) {
  return from < to ? low < to && high > from : low <= from && high >= from;
}

bool shares(const TickRect& area, const TickRect& rect) {
  return spans(area.west, area.east, rect.west, rect.east) &&
         spans(area.south, area.north, rect.south, rect.north);
}

TickRect in_world(TickRect area) {
  area.east = std::min(area.east, kTicksAround);
  area.north = std::min(area.north, kTicksPoleToPole);
  return area;
}

/// The tiles of a level that share more than an edge with the rectangle, or touch it where it is a line.
struct TileSpan {
  std::int32_t first_x, last_x, first_y, last_y;
};
TileSpan tiles_over(const TickRect& rect, int level) {
  const std::int64_t side = tile_ticks(level);
  const auto first = [side](std::int64_t from, std::int64_t to) {
    return static_cast<std::int32_t>((from == to ? std::max<std::int64_t>(from - 1, 0) : from) / side);
  };
  const auto last = [side](std::int64_t from, std::int64_t to) {
    return static_cast<std::int32_t>((from == to ? to : to - 1) / side);
  };
  return {first(rect.west, rect.east), std::min(last(rect.west, rect.east), tiles_around(level) - 1),
          first(rect.south, rect.north),
          std::min(last(rect.south, rect.north), tiles_pole_to_pole(level) - 1)};
}

}  // namespace

PackPatches::PackPatches(const PackReader& pack, std::optional<double> finest_error_m)
    : pack_(pack), finest_error_m_(finest_error_m) {
  const auto levels = pack.levels(Layer::heights);
  assert(levels);
  coarsest_ = levels->coarsest;
  finest_ = levels->finest;
}

void PackPatches::descend(const IndexEntry& entry, const TickRect& rect, const Wanted& wanted,
                          std::vector<Patch>& out) const {
  const TickRect area = in_world(ticks_of(entry.id));
  if (!shares(area, rect)) return;
  const auto own_error = static_cast<double>(entry.geometric_error_m);
  std::array<std::optional<IndexEntry>, 4> children;
  const bool is_enough = own_error <= wanted.error_m && !(wanted.whole && (entry.flags & kHasVoids) != 0);
  if (!is_enough && entry.id.level < std::min(wanted.finest, finest_)) {
    for (int q = 0; q < 4; ++q)
      if (const TileId child = child_of(entry.id, q); is_valid(child))
        children[static_cast<std::size_t>(q)] = pack_.find(Layer::heights, child);
  }
  if (std::none_of(children.begin(), children.end(), [](const auto& c) { return c.has_value(); })) {
    out.push_back({entry, area, own_error});
    return;
  }
  for (int q = 0; q < 4; ++q) {
    if (const auto& child = children[static_cast<std::size_t>(q)]; child) {
      descend(*child, rect, wanted, out);
      continue;
    }
    if (!is_valid(child_of(entry.id, q))) continue;
    // A child that was left out lies within the error bound of this surface.
    const TickRect quarter = in_world(ticks_of(child_of(entry.id, q)));
    if (shares(quarter, rect))
      out.push_back({entry, quarter, finest_error_m_ ? std::min(own_error, *finest_error_m_) : own_error});
  }
}

std::vector<Patch> PackPatches::over(const TickRect& rect, double error_m, int finest) const {
  return over(rect, {error_m, finest, false});
}

std::vector<Patch> PackPatches::over_with_rims(const TickRect& rect, double error_m) const {
  return over(rect, {error_m, finest_, true});
}

std::vector<Patch> PackPatches::over_rims(const TickRect& rect) const {
  return over(rect, {std::numeric_limits<double>::infinity(), finest_, true});
}

std::vector<Patch> PackPatches::over(const TickRect& rect, const Wanted& wanted) const {
  std::vector<Patch> out;
  const TileSpan span = tiles_over(rect, coarsest_);
  for (std::int32_t y = span.first_y; y <= span.last_y; ++y)
    for (std::int32_t x = span.first_x; x <= span.last_x; ++x)
      if (const auto entry = pack_.find(Layer::heights, {coarsest_, x, y}))
        descend(*entry, rect, wanted, out);
  return out;
}

bool PackPatches::has_tile(const TickRect& rect, int level) const {
  const TileSpan span = tiles_over(rect, std::max(level, coarsest_));
  for (std::int32_t y = span.first_y; y <= span.last_y; ++y)
    for (std::int32_t x = span.first_x; x <= span.last_x; ++x)
      if (pack_.find(Layer::heights, {std::max(level, coarsest_), x, y})) return true;
  return false;
}

std::optional<PackPatches::TilePlace> PackPatches::tile_at(std::int64_t x, std::int64_t y, int finest) const {
  for (int level = std::min(finest, finest_); level >= coarsest_; --level) {
    // Both ends of the antimeridian are one place.
    for (const std::int64_t turned : {x, x == 0 ? kTicksAround : x == kTicksAround ? 0 : x}) {
      const TileSpan span = tiles_over({turned, y, turned, y}, level);
      for (std::int32_t ty = span.last_y; ty >= span.first_y; --ty)
        for (std::int32_t tx = span.last_x; tx >= span.first_x; --tx)
          if (const auto entry = pack_.find(Layer::heights, {level, tx, ty}))
            return TilePlace{*entry, turned};
    }
  }
  return std::nullopt;
}

double PackPatches::range_of(const IndexEntry& entry) const {
  return (static_cast<double>(entry.max_quanta) - entry.min_quanta) * pack_.header().quantum_m;
}

PackPatches::Range PackPatches::range_over(const TickRect& rect, int level) const {
  level = std::clamp(level, coarsest_, finest_);
  Range range;
  bool any = false;
  const TileSpan span = tiles_over(rect, level);
  for (std::int32_t y = span.first_y; y <= span.last_y; ++y) {
    for (std::int32_t x = span.first_x; x <= span.last_x; ++x) {
      const auto entry = pack_.find_nearest(Layer::heights, {level, x, y});
      if (!entry) {
        range.complete = false;
        continue;
      }
      const double low = entry->min_quanta * pack_.header().quantum_m;
      const double high = entry->max_quanta * pack_.header().quantum_m;
      range.lowest_m = any ? std::min(range.lowest_m, low) : low;
      range.highest_m = any ? std::max(range.highest_m, high) : high;
      range.error_m = std::max(range.error_m, static_cast<double>(entry->geometric_error_m));
      range.complete = range.complete && (entry->flags & kHasVoids) == 0;
      any = true;
    }
  }
  return range;
}

}  // namespace cairn
