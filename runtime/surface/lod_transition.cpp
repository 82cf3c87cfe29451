#include "runtime/surface/lod_transition.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cairn {
namespace {

double level_of(const RenderTile& tile) {
  return tile.heights_id.level;
}

bool contains(const TileId& outer, const TileId& inner) {
  return outer.level <= inner.level && ancestor_of(inner, outer.level) == outer;
}

/// The detail after a frame in which no height may move by more than `allowed_m`, unless the fade would take
/// longer than the longest. Between two levels, heights move in proportion, by what the step between the
/// levels adds at most.
double moved(double detail, double wanted, const SurfaceTile& surface, double allowed_m,
             double longest_fade) {
  const DecimationErrors& errors = surface.errors;
  double left_m = allowed_m, at = detail;
  while (at != wanted) {
    const bool up = wanted > at;
    const int lower = static_cast<int>(up ? std::floor(at) : std::ceil(at) - 1);
    const double end = up ? std::min(wanted, lower + 1.0) : std::max(wanted, static_cast<double>(lower));
    const auto k = static_cast<std::size_t>(surface.id.level - lower);
    const double step_m = static_cast<double>(errors[k]) - static_cast<double>(errors[k - 1]);
    const double needed_m = step_m * std::abs(end - at);
    if (needed_m > left_m) {
      at += (up ? 1 : -1) * left_m / step_m;
      break;
    }
    left_m -= needed_m;
    at = end;
  }
  const double least = std::max(1.0, std::abs(wanted - detail)) / longest_fade;
  return wanted > detail ? std::max(at, std::min(wanted, detail + least))
                         : std::min(at, std::max(wanted, detail - least));
}

ShownTile settled(const RenderTile& tile) {
  return {tile, level_of(tile), level_of(tile), false};
}

/// A tile in the place of one that showed its area or more.
ShownTile successor(const ShownTile& old, const RenderTile& tile) {
  ShownTile now = settled(tile);
  if (!old.tile.visible || !old.tile.heights) return now;
  now.detail = std::min(old.detail, now.wanted);
  now.moves = old.moves || now.detail != now.wanted;
  return now;
}

/// Whether a coarser tile may take the place of these: none loses detail any more that could be seen.
bool can_coarsen(std::span<const ShownTile> group, const RenderTile& coarser) {
  return !coarser.heights || std::all_of(group.begin(), group.end(), [&](const ShownTile& shown) {
    return !shown.tile.visible || !shown.tile.heights || (!shown.moves && shown.detail <= level_of(coarser));
  });
}

/// A tile that is shown on, while it loses what the coarser one has not.
ShownTile held(const ShownTile& old, const RenderTile& coarser, const glm::dvec3& eye) {
  ShownTile now = old;
  now.tile.visible = coarser.visible;
  now.tile.distance_m = std::max(coarser.distance_m, old.tile.volume.distance_m(eye));
  now.wanted = std::min(level_of(old.tile), level_of(coarser));
  now.moves = old.moves || now.detail != now.wanted;
  return now;
}

}  // namespace

void LodTransition::move(const FrameScale& scale, const SurfaceOf& surface_of) {
  for (ShownTile& shown : shown_) {
    shown.moves = shown.detail != shown.wanted;
    if (!shown.moves) continue;
    const SurfaceTile* surface = shown.tile.visible ? surface_of(shown.tile) : nullptr;
    if (!surface) {
      shown.detail = shown.wanted;
      continue;
    }
    const double distance_m = shown.tile.volume.distance_m(scale.eye);
    const double allowed_m = scale.tolerance_px / 2 * distance_m / scale.pixels_per_radian;
    const double detail = ShownSurface::of(surface, shown.detail).detail;
    shown.detail = moved(detail, shown.wanted, *surface, allowed_m, scale.longest_fade);
  }
}

void LodTransition::follow(const RenderList& list, const glm::dvec3& eye) {
  std::vector<ShownTile> next;
  next.reserve(std::max(shown_.size(), list.tiles.size()));
  std::size_t i = 0, j = 0;
  while (i < shown_.size() && j < list.tiles.size()) {
    const TileId old = shown_[i].tile.area, now = list.tiles[j].area;
    if (old.level <= now.level) {
      for (; j < list.tiles.size() && contains(old, list.tiles[j].area); ++j) {
        next.push_back(successor(shown_[i], list.tiles[j]));
      }
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < shown_.size() && contains(now, shown_[end].tile.area)) ++end;
    const std::span<const ShownTile> group(&shown_[i], end - i);
    if (can_coarsen(group, list.tiles[j])) {
      next.push_back(settled(list.tiles[j]));
    } else {
      for (const ShownTile& shown : group) next.push_back(held(shown, list.tiles[j], eye));
    }
    i = end;
    ++j;
  }
  shown_ = std::move(next);
}

std::span<const ShownTile> LodTransition::update(const RenderList& list, const FrameScale& scale,
                                                 const SurfaceOf& surface_of) {
  if (shown_.empty()) {
    for (const RenderTile& tile : list.tiles) shown_.push_back(settled(tile));
  } else {
    move(scale, surface_of);
    follow(list, scale.eye);
  }
  return shown_;
}

}  // namespace cairn
