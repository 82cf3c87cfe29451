#include "runtime/lod/mesh/bisection_forest.h"

#include <algorithm>
#include <bit>
#include <unordered_map>

namespace cairn {
namespace {

constexpr unsigned opposite(unsigned side) {
  return (side + 2) % 4;
}

/// A side of a tile, in lattice units: the line that it lies on, and its ends along that line.
struct SideOf {
  std::int64_t line = 0;
  std::int64_t low = 0;
  std::int64_t high = 0;
};

SideOf side_of(const TileId& area, unsigned side) {
  const LatticePoint corner = south_west_of(area);
  const std::int64_t width = lattice_width(area.level);
  switch (side) {
    case BisectionForest::south:
      return {corner.y, corner.x, corner.x + width};
    case BisectionForest::north:
      return {corner.y + width, corner.x, corner.x + width};
    case BisectionForest::west:
      return {corner.x, corner.y, corner.y + width};
    default:
      return {canonical({corner.x + width, 0}).x, corner.y, corner.y + width};
  }
}

}  // namespace

void BisectionForest::prepare(const LodScene& scene) {
  trees_.clear();
  trees_.resize(scene.tiles.size());
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    const TileWindow window(scene, scene.tiles[i]);
    Tree& tree = trees_[i];
    tree.levels = std::bit_width(static_cast<unsigned>(window.cells())) - 1;
    tree.spacing = window.spacing();
    tree.corner = window.point(0, 0);
    std::size_t squares = 0;
    for (int k = tree.levels; k >= 1; --k) {
      tree.first[static_cast<std::size_t>(k)] = squares;
      squares += std::size_t{1} << (2 * (tree.levels - k));
    }
    tree.masks.assign(squares, 0);
  }
  find_neighbours(scene);
}

void BisectionForest::find_neighbours(const LodScene& scene) {
  has_finer_neighbour_.assign(trees_.size(), 0);
  std::array<std::unordered_map<std::int64_t, std::vector<std::size_t>>, 4> on_line;
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    for (unsigned side = 0; side < 4; ++side)
      on_line[side][side_of(scene.tiles[i].area, side).line].push_back(i);
  }
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    for (unsigned side = 0; side < 4; ++side) {
      const SideOf own = side_of(scene.tiles[i].area, side);
      const auto others = on_line[opposite(side)].find(own.line);
      if (others == on_line[opposite(side)].end()) continue;
      for (const std::size_t other : others->second) {
        const SideOf beyond = side_of(scene.tiles[other].area, opposite(side));
        if (beyond.low >= own.high || own.low >= beyond.high) continue;
        trees_[i].neighbours[side].push_back({other, beyond.low, beyond.high});
        if (trees_[other].spacing < trees_[i].spacing) has_finer_neighbour_[i] = 1;
      }
    }
  }
}

std::uint64_t BisectionForest::bytes() const {
  std::uint64_t bytes = numbers_.size() * sizeof(std::uint32_t);
  for (const Tree& tree : trees_) {
    bytes += sizeof(Tree) + tree.masks.size() * sizeof(Mask);
    for (const auto& neighbours : tree.neighbours) bytes += neighbours.size() * sizeof(Neighbour);
  }
  return bytes;
}

void BisectionForest::begin() {
  for (Tree& tree : trees_) {
    if (tree.finest == kUntouched) continue;
    // Larger squares come first, so that all masks from the finest level's last one on are 0 already.
    const std::size_t end =
        tree.finest > 1 ? tree.first[static_cast<std::size_t>(tree.finest) - 1] : tree.masks.size();
    std::fill_n(tree.masks.begin(), end, Mask{0});
    tree.finest = kUntouched;
    tree.vertices = 0;
  }
  pending_.clear();
}

void BisectionForest::join_corners() {
  for (std::size_t i = 0; i < trees_.size(); ++i) enable_corners_of_neighbours(i);
}

void BisectionForest::enable_corners_of_neighbours(std::size_t tile) {
  const Tree& tree = trees_[tile];
  for (unsigned side = 0; side < 4; ++side) {
    const bool level = side == south || side == north;
    const std::int64_t low = level ? tree.corner.x : tree.corner.y;
    const std::int64_t high = low + (tree.spacing << tree.levels);
    for (const Neighbour& other : tree.neighbours[side]) {
      for (const std::int64_t at : {other.low, other.high}) {
        const std::int64_t half = at & -at;  // half an edge of the largest square whose middle this is
        if (at <= low || at >= high || half < tree.spacing) continue;
        const int k = std::countr_zero(static_cast<std::uint64_t>(2 * half / tree.spacing));
        const int along = static_cast<int>((at - low) / (2 * half)), across = (1 << (tree.levels - k)) - 1;
        if (level) {
          enable_middle(tile, k, along, side == north ? across : 0, static_cast<Side>(side));
        } else {
          enable_middle(tile, k, side == east ? across : 0, along, static_cast<Side>(side));
        }
      }
    }
  }
}

bool BisectionForest::has(std::size_t tile, int c, int r) const {
  const Tree& tree = trees_[tile];
  const int last = 1 << tree.levels, both = c | r, h = both & -both;
  const int k = std::countr_zero(static_cast<unsigned>(h)) + 1;
  const auto mask = [&](int x, int y) { return tree.masks[slot(tree, k, x, y)]; };
  if ((c & h) != 0 && (r & h) != 0) return (mask(c >> k, r >> k) & kCentre) != 0;
  if ((c & h) != 0)
    return (r < last ? mask(c >> k, r >> k) & bit_of(south) : mask(c >> k, (r >> k) - 1) & bit_of(north)) !=
           0;
  return (c < last ? mask(c >> k, r >> k) & bit_of(west) : mask((c >> k) - 1, r >> k) & bit_of(east)) != 0;
}

void BisectionForest::enable_centre(std::size_t tile, int k, int x, int y) {
  Tree& tree = trees_[tile];
  Mask& mask = tree.masks[slot(tree, k, x, y)];
  if ((mask & kCentre) != 0) return;
  mask |= kCentre;
  ++tree.vertices;
  tree.finest = std::min(tree.finest, k);
  add_pending({tile, k, x, y, kCentre});
  if (k == tree.levels) return;
  enable_middle(tile, k + 1, x / 2, y / 2, (y & 1) != 0 ? north : south);
  enable_middle(tile, k + 1, x / 2, y / 2, (x & 1) != 0 ? east : west);
}

void BisectionForest::enable_middle(std::size_t tile, int k, int x, int y, Side side) {
  Tree& tree = trees_[tile];
  Mask& mask = tree.masks[slot(tree, k, x, y)];
  if ((mask & bit_of(side)) != 0) return;
  mask |= bit_of(side);
  ++tree.vertices;
  if (k > 1) add_pending({tile, k, x, y, bit_of(side)});
  enable_centre(tile, k, x, y);
  const int bx = x + (side == east ? 1 : side == west ? -1 : 0);
  const int by = y + (side == north ? 1 : side == south ? -1 : 0);
  const int count = 1 << (tree.levels - k);
  if (bx < 0 || by < 0 || bx >= count || by >= count) {
    enable_beyond(tree, k, x, y, side);
    return;
  }
  tree.masks[slot(tree, k, bx, by)] |= bit_of(opposite(side));
  if (k > 1) add_pending({tile, k, bx, by, bit_of(opposite(side))});
  enable_centre(tile, k, bx, by);
}

void BisectionForest::enable_beyond(const Tree& tree, int k, int x, int y, Side side) {
  const std::int64_t size = tree.spacing << k;
  const bool level = side == south || side == north;
  const std::int64_t from = level ? tree.corner.x + x * size : tree.corner.y + y * size;
  for (const Neighbour& beyond : tree.neighbours[side]) {
    if (from + size / 2 <= beyond.low || from + size / 2 >= beyond.high) continue;
    const Tree& other = trees_[beyond.tile];
    if (size < 2 * other.spacing) return;
    const int there = std::countr_zero(static_cast<std::uint64_t>(size / other.spacing));
    const int along = static_cast<int>((from - beyond.low) / size);
    const int across = side == south || side == west ? (1 << (other.levels - there)) - 1 : 0;
    enable_middle(beyond.tile, there, level ? along : across, level ? across : along,
                  static_cast<Side>(opposite(side)));
    return;
  }
}

}  // namespace cairn
