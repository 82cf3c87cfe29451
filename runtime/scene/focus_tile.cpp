#include "runtime/scene/focus_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "cairn/geodesy.h"

namespace cairn {

double level_for_pixel_size(const ViewState& view, double distance_m, int tile_size) {
  return std::log2(view.ellipsoid.equator_degree_m() / (tile_size - 1) /
                   pixel_footprint_m(view, std::max(distance_m, 1.0)));
}

FocusTile::FocusTile(double tile_margin, double level_margin)
    : tile_margin_(tile_margin), level_margin_(level_margin) {
  assert(tile_margin >= 0 && tile_margin < 1 && level_margin >= 0 && level_margin < 1);
}

TileId FocusTile::update(LonLat eye, double ideal_level, int coarsest, int finest) {
  const int level = level_for(ideal_level, coarsest, finest);
  if (!held_ || held_->level != level || !holds(eye)) held_ = tile_at(eye, level);
  return *held_;
}

int FocusTile::level_for(double ideal_level, int coarsest, int finest) const {
  if (held_ && held_->level >= coarsest && held_->level <= finest &&
      ideal_level > held_->level - 1 - level_margin_ && ideal_level <= held_->level + level_margin_) {
    return held_->level;
  }
  const double level = std::ceil(std::clamp(ideal_level, -100.0, 100.0));
  return std::clamp(static_cast<int>(level), coarsest, finest);
}

bool FocusTile::holds(LonLat eye) const {
  const GeoBounds bounds = tile_bounds(*held_);
  const double margin = tile_margin_ * tile_width_degrees(held_->level);
  const double middle = bounds.west + bounds.width() / 2;
  const double east_of_middle = std::remainder(eye.lon - middle, 360.0);
  return std::abs(east_of_middle) <= bounds.width() / 2 + margin && eye.lat >= bounds.south - margin &&
         eye.lat <= bounds.north + margin;
}

}  // namespace cairn
