#include "runtime/query/ground_tiles.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/view/ground_height.h"

namespace cairn {
namespace {

constexpr double kNothing_m = -std::numeric_limits<double>::infinity();
constexpr std::int32_t kVoid = std::numeric_limits<std::int32_t>::min();
// From here on tiles line up across ±180° and end at the poles.
constexpr int kCoarsestAligned = -2;

std::size_t index_of(int column, int row, int side) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(column);
}

/// Degrees to the east of a meridian, from -180 to 180.
double east_of(double meridian, double lon) {
  return std::remainder(lon - meridian, 360.0);
}

double middle_lon(const GeoBounds& bounds) {
  return bounds.west + bounds.width() / 2;
}

double error_m_of(const IndexEntry& entry) {
  return static_cast<double>(entry.geometric_error_m);
}

}  // namespace

GroundTile::GroundTile(const IndexEntry& entry, HeightTile tile, const PackHeader& pack)
    : entry_(entry), tile_(std::move(tile)), quantum_m_(pack.quantum_m), ellipsoid_(pack.body.shape) {
  Maxima cells{tile_.size - 1, {}};
  cells.highest.reserve(index_of(0, cells.side, cells.side));
  for (int row = 0; row < cells.side; ++row) {
    for (int column = 0; column < cells.side; ++column) {
      std::int32_t highest = kVoid;
      for (int corner = 0; corner < 4; ++corner) {
        const int c = column + (corner & 1), r = row + (corner >> 1);
        if (!tile_.is_void(c, r)) highest = std::max(highest, tile_.at(c, r));
      }
      cells.highest.push_back(highest);
    }
  }
  maxima_.push_back(std::move(cells));
  while (maxima_.back().side > 1) {
    const Maxima& finer = maxima_.back();
    Maxima coarser{finer.side / 2, {}};
    for (int row = 0; row < coarser.side; ++row) {
      for (int column = 0; column < coarser.side; ++column) {
        std::int32_t highest = kVoid;
        for (int corner = 0; corner < 4; ++corner) {
          const int c = 2 * column + (corner & 1), r = 2 * row + (corner >> 1);
          highest = std::max(highest, finer.highest[index_of(c, r, finer.side)]);
        }
        coarser.highest.push_back(highest);
      }
    }
    maxima_.push_back(std::move(coarser));
  }
}

GroundTile::Position GroundTile::position_of(LonLat place) const {
  const GeoBounds b = tile_bounds(entry_.id);
  const int cells = tile_.size - 1;
  const auto along = [cells](double degrees, double width) {
    return std::clamp(degrees / width, 0.0, 1.0) * cells;
  };
  Position at;
  at.column = along(east_of(middle_lon(b), place.lon) + b.width() / 2, b.width());
  at.row = along(place.lat - b.south, b.height());
  at.cell_column = std::min(static_cast<int>(at.column), cells - 1);
  at.cell_row = std::min(static_cast<int>(at.row), cells - 1);
  return at;
}

std::optional<double> GroundTile::height_m(const Position& at) const {
  const double u = at.column - at.cell_column, v = at.row - at.cell_row;
  const std::array<double, 4> weights{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  double quanta = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const double weight = weights[static_cast<std::size_t>(corner)];
    if (weight == 0) continue;
    const int column = at.cell_column + (corner & 1), row = at.cell_row + (corner >> 1);
    if (tile_.is_void(column, row)) return std::nullopt;
    quanta += weight * tile_.at(column, row);
  }
  return quanta * quantum_m_;
}

std::optional<glm::dvec3> GroundTile::normal(LonLat place) const {
  const Position at = position_of(place);
  std::array<glm::dvec3, 4> corners{};
  const GeoBounds b = tile_bounds(entry_.id);
  const double cell_degrees = b.width() / (tile_.size - 1);
  for (int corner = 0; corner < 4; ++corner) {
    const int column = at.cell_column + (corner & 1), row = at.cell_row + (corner >> 1);
    if (tile_.is_void(column, row)) return std::nullopt;
    corners[static_cast<std::size_t>(corner)] =
        to_geocentric({b.west + column * cell_degrees, b.south + row * cell_degrees},
                      tile_.at(column, row) * quantum_m_, ellipsoid_);
  }
  const double u = at.column - at.cell_column, v = at.row - at.cell_row;
  const glm::dvec3 east = (corners[1] - corners[0]) * (1 - v) + (corners[3] - corners[2]) * v;
  const glm::dvec3 north = (corners[2] - corners[0]) * (1 - u) + (corners[3] - corners[1]) * u;
  const glm::dvec3 normal = glm::cross(east, north);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : local_frame(place).up;  // at a pole there is no way east
}

double GroundTile::ceiling_m(const CellRange& cells) const {
  std::size_t level = 0;
  const auto spans = [&](int first, int last) { return (last >> level) - (first >> level); };
  while (level + 1 < maxima_.size() &&
         (spans(cells.west, cells.east) > 1 || spans(cells.south, cells.north) > 1)) {
    ++level;
  }
  const Maxima& maxima = maxima_[level];
  std::int32_t highest = kVoid;
  for (int row = cells.south >> level; row <= cells.north >> level; ++row) {
    for (int column = cells.west >> level; column <= cells.east >> level; ++column) {
      highest = std::max(highest, maxima.highest[index_of(column, row, maxima.side)]);
    }
  }
  return highest == kVoid ? kNothing_m : highest * quantum_m_;
}

GroundTiles::GroundTiles(std::shared_ptr<const PackReader> pack, std::size_t most_tiles)
    : pack_(std::move(pack)), most_tiles_(most_tiles), highest_m_(highest_ground_m(*pack_)) {
  assert(most_tiles >= 1);
}

Result<const GroundTile*> GroundTiles::tile(const IndexEntry& entry) {
  const auto found = std::find_if(tiles_.begin(), tiles_.end(),
                                  [&](const GroundTile& t) { return t.entry().id == entry.id; });
  if (found != tiles_.end()) {
    tiles_.splice(tiles_.begin(), tiles_, found);
    return &tiles_.front();
  }
  Result<HeightTile> read = pack_->read_height_tile(entry);
  if (!read) return read.error();
  if (tiles_.size() == most_tiles_) tiles_.pop_back();
  tiles_.emplace_front(entry, std::move(*read), pack_->header());
  return &tiles_.front();
}

Result<const GroundTile*> GroundTiles::at(LonLat place) {
  const auto levels = pack_->levels(Layer::heights);
  if (!levels) return static_cast<const GroundTile*>(nullptr);
  const auto entry = pack_->find_nearest(Layer::heights, tile_at(place, levels->finest));
  if (!entry) return static_cast<const GroundTile*>(nullptr);
  return tile(*entry);
}

bool GroundTiles::has_children(const TileId& id) const {
  for (int quadrant = 0; quadrant < 4 && id.level < kMaxLevel; ++quadrant) {
    const TileId child = child_of(id, quadrant);
    if (is_valid(child) && pack_->find_index(Layer::heights, child)) return true;
  }
  return false;
}

Result<double> GroundTiles::ceiling_m(LonLat place, double lon_reach, double lat_reach, bool errors) {
  const auto levels = pack_->levels(Layer::heights);
  if (!levels) return kNothing_m;
  // The finest level whose tiles are as wide as the area: four of them cover it.
  int level = levels->finest;
  const double width = 2 * std::max(lon_reach, lat_reach);
  while (level >= kCoarsestAligned && tile_width_degrees(level) < width) --level;
  if (level < std::max(levels->coarsest, kCoarsestAligned)) return highest_m_;
  std::array<TileId, 4> ids;
  double ceiling_m = kNothing_m;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const double lon = place.lon + (corner & 1 ? lon_reach : -lon_reach);
    const double lat = std::clamp(place.lat + (corner & 2 ? lat_reach : -lat_reach), -90.0, 90.0);
    ids[corner] = tile_at({lon, lat}, level);
    if (std::find(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(corner), ids[corner]) !=
        ids.begin() + static_cast<std::ptrdiff_t>(corner))
      continue;
    const Result<double> here = ceiling_in(ids[corner], place, lon_reach, lat_reach, errors);
    if (!here) return here.error();
    ceiling_m = std::max(ceiling_m, *here);
  }
  return ceiling_m;
}

Result<double> GroundTiles::ceiling_in(const TileId& id, LonLat place, double lon_reach, double lat_reach,
                                       bool errors) {
  const auto entry = pack_->find_nearest(Layer::heights, id);
  if (!entry) return kNothing_m;
  const double error_m = errors ? error_m_of(*entry) : 0;
  const double highest_m = entry->max_quanta * pack_->header().quantum_m;
  if (entry->id == id && has_children(id)) return highest_m + error_m_of(*entry);
  if (entry->id == id && id.level < pack_->levels(Layer::heights)->finest) return highest_m + error_m;
  const Result<const GroundTile*> ground = tile(*entry);
  if (!ground) return ground.error();
  const GeoBounds b = tile_bounds(entry->id);
  const int cells = pack_->header().tile_size - 1;
  const auto cell = [cells](double degrees, double extent) {
    return static_cast<int>(std::clamp(std::floor(degrees / extent * cells), 0.0, cells - 1.0));
  };
  const double east = east_of(middle_lon(b), place.lon) + b.width() / 2, north = place.lat - b.south;
  const CellRange range{cell(east - lon_reach, b.width()), cell(north - lat_reach, b.height()),
                        cell(east + lon_reach, b.width()), cell(north + lat_reach, b.height())};
  return (*ground)->ceiling_m(range) + error_m;
}

}  // namespace cairn
