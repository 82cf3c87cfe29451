#include "format/rqt_borders.h"

#include <algorithm>

namespace cairn {
namespace {

// South, east, north, west.
constexpr int kSides = 4;
constexpr std::array<std::array<int, 2>, kSides> kBeyond{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};

bool is_neighbour(const TileId& id, const TileId& beyond, int dx) {
  if (!is_valid(beyond)) return false;
  const bool wraps = dx != 0 && beyond.x != id.x + dx;
  return !wraps || id.level >= -3;
}

}  // namespace

// All that a border vertex needs, and they need, as far as it is on the border. The root's diagonal does not
// matter: it says which corners its centre needs, and corners are always there.
std::vector<std::uint16_t> RqtBorders::needs_on_border(std::size_t i) const {
  const auto size = static_cast<std::size_t>(size_);
  const Place from = place_of(i);
  std::vector<std::size_t> open{static_cast<std::size_t>(from.row) * size +
                                static_cast<std::size_t>(from.column)};
  std::vector<std::size_t> seen;
  std::vector<std::uint16_t> on_border;
  while (!open.empty()) {
    const std::size_t vertex = open.back();
    open.pop_back();
    const Place place{static_cast<int>(vertex % size), static_cast<int>(vertex / size)};
    if (is_corner(place) || std::find(seen.begin(), seen.end(), vertex) != seen.end()) continue;
    seen.push_back(vertex);
    if (is_on_border(place)) on_border.push_back(static_cast<std::uint16_t>(number_of(place)));
    const RqtNeeds needs = rqt_needs_of(place.column, place.row, size_, true);
    open.insert(open.end(), {needs.first, needs.second});
  }
  return on_border;
}

RqtBorders::RqtBorders(int tile_size) : size_(tile_size) {
  needs_.resize(static_cast<std::size_t>(kSides) * static_cast<std::size_t>(size_ - 2));
  for (std::size_t i = 0; i < needs_.size(); ++i) needs_[i] = needs_on_border(i);
}

bool RqtBorders::is_on_border(Place p) const {
  return p.column == 0 || p.row == 0 || p.column == size_ - 1 || p.row == size_ - 1;
}

bool RqtBorders::is_corner(Place p) const {
  return (p.column == 0 || p.column == size_ - 1) && (p.row == 0 || p.row == size_ - 1);
}

std::size_t RqtBorders::number_of(Place p) const {
  const int inner = size_ - 2;
  const int side = p.row == 0 ? 0 : p.column == size_ - 1 ? 1 : p.row == size_ - 1 ? 2 : 3;
  return static_cast<std::size_t>(side * inner + (side % 2 == 0 ? p.column : p.row) - 1);
}

RqtBorders::Place RqtBorders::place_of(std::size_t i) const {
  const int inner = size_ - 2;
  const int along = 1 + static_cast<int>(i) % inner;
  switch (static_cast<int>(i) / inner) {
    case 0:
      return {along, 0};
    case 1:
      return {size_ - 1, along};
    case 2:
      return {along, size_ - 1};
    default:
      return {0, along};
  }
}

void RqtBorders::add(const TileId& id, const RqtSteps& own) {
  Border border(needs_.size());
  for (std::size_t i = 0; i < border.size(); ++i) {
    const Place place = place_of(i);
    border[i] = static_cast<std::uint8_t>(own.at(place.column, place.row));
  }
  borders_.insert_or_assign(id, std::move(border));
}

void RqtBorders::raise(const TileId& id, Border& border, std::size_t i, std::uint8_t steps) {
  if (border[i] >= steps) return;
  border[i] = steps;
  for (const std::uint16_t j : needs_[i]) border[j] = std::max(border[j], steps);
  if (changed_.empty() || changed_.back() != id) changed_.push_back(id);
}

void RqtBorders::pass_on(const TileId& id, const Border& border, int side) {
  const auto [dx, dy] = kBeyond[static_cast<std::size_t>(side)];
  const TileId beyond = neighbour_of(id, dx, dy);
  if (!is_neighbour(id, beyond, dx)) return;
  const auto other = borders_.find(beyond);
  if (other == borders_.end()) return;
  const auto inner = static_cast<std::size_t>(size_ - 2);
  const std::size_t from = static_cast<std::size_t>(side) * inner;
  const std::size_t to = static_cast<std::size_t>((side + 2) % kSides) * inner;
  for (std::size_t k = 0; k < inner; ++k) raise(beyond, other->second, to + k, border[from + k]);
}

void RqtBorders::settle() {
  changed_.clear();
  for (const auto& [id, border] : borders_) changed_.push_back(id);
  while (!changed_.empty()) {
    const TileId id = changed_.back();
    changed_.pop_back();
    const Border& border = borders_.at(id);
    for (int side = 0; side < kSides; ++side) pass_on(id, border, side);
  }
}

void RqtBorders::apply(const TileId& id, RqtSteps& own) const {
  const auto found = borders_.find(id);
  if (found == borders_.end()) return;
  for (std::size_t i = 0; i < found->second.size(); ++i) {
    const Place place = place_of(i);
    own.raise(place.column, place.row, found->second[i]);
  }
}

}  // namespace cairn
