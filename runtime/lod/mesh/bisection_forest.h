#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {

/// The restricted quadtree triangulation of a whole scene [3; Pajarola 1998]: tiles of any levels are squares
/// of one hierarchy, so that a vertex on a border needs vertices on both sides of it and gets them.
///
/// Level k of a tile's window has squares of 2^k cells, (x, y) counted from the south-west. A square has a
/// centre and the middles of its four edges. A middle needs the centres of the squares on both sides of its
/// edge; a centre needs those two middles of the next larger square that are corners of its own.
///
/// Where a neighbour has no sample at a vertex, its mesh gets none: remove_t_junctions() splits a triangle of
/// one cell there. A tile's corners are vertices of all that touch it, as far as they have samples there.
class BisectionForest {
 public:
  enum Side : unsigned { south, east, north, west };
  static constexpr int kNeverCull = 16;  ///< a cull_level that no square has
  /// (column, row) of three samples of a tile's window, anticlockwise; the right angle is the last's.
  using Corner = std::array<int, 2>;
  using Triangle = std::array<Corner, 3>;

  /// Finds the neighbours. Until the next call a tile is named by its number in this scene.
  void prepare(const LodScene& scene);
  std::uint64_t bytes() const;

  int levels(std::size_t tile) const { return trees_[tile].levels; }  ///< log2 of the window's cells

  /// Tiles beside which others have samples closer together, and so vertices that these lack: by number.
  const std::vector<char>& meet_finer() const { return meet_finer_; }

  /// Begins a mesh: no vertices but each tile's own corners, none wanted.
  void begin();
  /// Adds the vertex and all that it needs, in other tiles too. REQUIRES: 1 <= k <= levels(tile).
  void enable_centre(std::size_t tile, int k, int x, int y);
  void enable_middle(std::size_t tile, int k, int x, int y, Side side);

  /// Says that a triangle of this square is not to stay as it is: one that would be bisected at the vertex.
  /// settle() adds the vertex if the mesh comes to have that triangle; where a larger triangle does, the
  /// vertex is not needed. REQUIRES: as for the above.
  void want_centre(std::size_t tile, int k, int x, int y) { mark(tile, k, x, y, kCentre << kWanted); }
  void want_middle(std::size_t tile, int k, int x, int y, Side side) {
    mark(tile, k, x, y, static_cast<Mask>(bit_of(side) << kWanted));
  }
  /// Says that what the square wants needs no confirming. REQUIRES: as for the above.
  void trust(std::size_t tile, int k, int x, int y) { mark(tile, k, x, y, kSkipTestBelow); }
  /// Ends a mesh: adds the corners that tiles have on their neighbours' borders, as far as these have samples
  /// there, then what is wanted of the mesh's triangles until none wants to be bisected. `select(tile, k, x,
  /// y)` is asked once for each square that the mesh comes to have triangles in, the larger ones first: it
  /// wants what it wants of the square and, if it says true, of all within, which are not asked for then.
  /// `confirms(tile, triangle)` is asked last, once for each triangle that wants to be bisected, unless its
  /// square is trusted.
  template <class Select, class Confirms>
  void settle(const Select& select, const Confirms& confirms);
  /// The same with nothing wanted.
  void settle() { join_corners(); }

  /// Whether the sample (c, r) of the window is a vertex. REQUIRES: it is not one of its corners.
  bool has(std::size_t tile, int c, int r) const;

  /// Appends a tile's triangles, without the squares that `sees(k, x, y)` says no to: a square of at least
  /// 2^cull_level cells, whose inside no other asks for. Each inner square is a fan around its centre.
  /// Of the squares' vertices in it, the share that these did not want themselves: there for others.
  template <class Sees>
  double append(const LodScene& scene, std::size_t tile, int cull_level, const Sees& sees, LodMesh& mesh);

 private:
  /// The vertices of a square that are enabled; shifted, those that are wanted.
  using Mask = std::uint16_t;
  static constexpr Mask kCentre = 1;
  static constexpr Mask bit_of(unsigned side) { return static_cast<Mask>(2u << side); }
  static constexpr Mask kSkipTestBelow = 1 << 5;  ///< what it wants needs no confirming
  static constexpr Mask kSelected = 1 << 6;       ///< the square's vertices are wanted, or not
  static constexpr Mask kAllSelected = 1 << 7;    ///< those within it, too
  static constexpr Mask kVertices = 0x1f;         ///< all five
  static constexpr int kWanted = 8;
  static constexpr int kUntouched = 16;

  struct Beside {
    std::size_t tile;
    std::int64_t low;  ///< of its side, along the border
    std::int64_t high;
  };
  struct Tree {
    int levels = 0;
    std::int64_t spacing = 0;
    LatticePoint corner;
    std::array<std::size_t, 16> first{};  ///< in masks, of each level's squares
    std::vector<Mask> masks;
    std::array<std::vector<Beside>, 4> beside;
    int finest = kUntouched;   ///< of the levels whose masks are not all 0
    std::size_t vertices = 0;  ///< that are enabled
  };
  /// A vertex of a square, whose triangles may want to be bisected.
  struct Open {
    std::size_t tile;
    int k;
    int x;
    int y;
    Mask vertex;
  };
  struct Emitter;

  static std::size_t slot(const Tree& tree, int k, int x, int y) {
    return tree.first[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (tree.levels - k)) +
           static_cast<std::size_t>(x);
  }
  void find_neighbours(const LodScene& scene);
  void mark(std::size_t tile, int k, int x, int y, Mask bits) {
    Tree& tree = trees_[tile];
    tree.masks[slot(tree, k, x, y)] |= bits;
    tree.finest = std::min(tree.finest, k);
  }
  void open(const Open& square) {
    if (opens_) open_.push_back(square);
  }
  void join_corners();
  template <class Select>
  void select_once(std::size_t tile, int k, int x, int y, const Select& select);
  template <class Select, class Confirms>
  void bisect_at_edges(const Open& centre, const Select& select, const Confirms& confirms);
  template <class Select, class Confirms>
  void bisect_beside(const Open& middle, const Select& select, const Confirms& confirms);
  void enable_beyond(const Tree& tree, int k, int x, int y, Side side);
  void enable_corners_of_neighbours(std::size_t tile);

  std::vector<Tree> trees_;
  std::vector<char> meet_finer_;
  std::vector<Open> open_;
  bool opens_ = false;
  std::vector<std::uint32_t> numbers_;  ///< of the vertices of the tile that is being appended
  std::vector<std::size_t> numbered_;
};

template <class Select, class Confirms>
void BisectionForest::settle(const Select& select, const Confirms& confirms) {
  opens_ = true;
  join_corners();
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    const int levels = trees_[i].levels;
    if (levels == 0) continue;
    select_once(i, levels, 0, 0, select);
    if ((trees_[i].masks.front() & kCentre << kWanted) != 0) enable_centre(i, levels, 0, 0);
  }
  while (!open_.empty()) {
    const Open next = open_.back();
    open_.pop_back();
    if (next.vertex == kCentre) {
      bisect_at_edges(next, select, confirms);
    } else {
      bisect_beside(next, select, confirms);
    }
  }
  opens_ = false;
}

template <class Select>
void BisectionForest::select_once(std::size_t tile, int k, int x, int y, const Select& select) {
  Tree& tree = trees_[tile];
  Mask& mask = tree.masks[slot(tree, k, x, y)];
  if ((mask & kSelected) != 0) return;
  tree.finest = std::min(tree.finest, k);
  mask |= kSelected;
  if (k < tree.levels) {
    select_once(tile, k + 1, x / 2, y / 2, select);
    if ((tree.masks[slot(tree, k + 1, x / 2, y / 2)] & kAllSelected) != 0) {
      mask |= kAllSelected;
      return;
    }
  }
  if (select(tile, k, x, y)) mask |= kAllSelected;
}

inline std::array<BisectionForest::Corner, 4> corners_of(int k, int x, int y) {
  const int west = x << k, south = y << k, east = west + (1 << k), north = south + (1 << k);
  return {{{west, south}, {east, south}, {east, north}, {west, north}}};
}

inline BisectionForest::Corner middle_of(const BisectionForest::Corner& a, const BisectionForest::Corner& b) {
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
}

// A square with its centre has a triangle at each edge without a middle.
template <class Select, class Confirms>
void BisectionForest::bisect_at_edges(const Open& centre, const Select& select, const Confirms& confirms) {
  const auto [tile, k, x, y, vertex] = centre;
  select_once(tile, k, x, y, select);
  const std::size_t at = slot(trees_[tile], k, x, y);
  const std::array<Corner, 4> corners = corners_of(k, x, y);
  const Corner middle = middle_of(corners[0], corners[2]);
  for (unsigned side = 0; side < 4; ++side) {
    const Mask mask = trees_[tile].masks[at];
    if ((mask >> kWanted & ~mask & bit_of(side)) == 0) continue;
    if ((mask & kSkipTestBelow) != 0 ||
        confirms(tile, Triangle{corners[side], corners[(side + 1) % 4], middle}))
      enable_middle(tile, k, x, y, static_cast<Side>(side));
  }
}

// With a middle, there is a triangle on both sides of it: half of a smaller square, unless that has a centre.
template <class Select, class Confirms>
void BisectionForest::bisect_beside(const Open& middle, const Select& select, const Confirms& confirms) {
  const auto [tile, k, x, y, vertex] = middle;
  const auto side = static_cast<unsigned>(std::countr_zero(vertex)) - 1;
  const std::array<Corner, 4> corners = corners_of(k, x, y);
  const Corner centre = middle_of(corners[0], corners[2]);
  const Corner at = middle_of(corners[side], corners[(side + 1) % 4]);
  for (const unsigned q : {side, (side + 1) % 4}) {
    const int cx = 2 * x + (q == 1 || q == 2 ? 1 : 0), cy = 2 * y + (q >= 2 ? 1 : 0);
    select_once(tile, k - 1, cx, cy, select);
    const Mask mask = trees_[tile].masks[slot(trees_[tile], k - 1, cx, cy)];
    if ((mask >> kWanted & ~mask & kCentre) == 0) continue;
    const Triangle half = q == side ? Triangle{centre, corners[q], at} : Triangle{corners[q], centre, at};
    if ((mask & kSkipTestBelow) != 0 || confirms(tile, half)) enable_centre(tile, k - 1, cx, cy);
  }
}

/// Appends one tile; its masks are as they were before begin() after it.
struct BisectionForest::Emitter {
  static constexpr std::uint32_t kNone = 0xffffffff;

  Emitter(BisectionForest& forest, const TileWindow& tile_window, Tree& its_tree, LodTileMesh& tile_mesh)
      : window(tile_window),
        tree(its_tree),
        mesh(tile_mesh),
        numbers(forest.numbers_),
        used(forest.numbered_) {
    const std::size_t side = static_cast<std::size_t>(window.cells()) + 1;
    if (numbers.size() < side * side) numbers.resize(side * side, kNone);
    for (const std::size_t i : used) numbers[i] = kNone;
    used.clear();
  }

  std::uint32_t add(int c, int r) {
    mesh.vertices.push_back(window.vertex(c, r));
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  }
  /// Of a vertex that two squares have.
  std::uint32_t shared(int c, int r) {
    const std::size_t i = static_cast<std::size_t>(r) * (static_cast<std::size_t>(window.cells()) + 1) +
                          static_cast<std::size_t>(c);
    if (numbers[i] == kNone) {
      numbers[i] = add(c, r);
      used.push_back(i);
    }
    return numbers[i];
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { mesh.triangles.push_back({a, b, c}); }

  /// A square with its centre enabled; the corners anticlockwise from the south-west.
  template <class Sees>
  void square(int k, int x, int y, const std::array<std::uint32_t, 4>& corners, int cull_level,
              const Sees& sees) {
    if (k >= cull_level && !sees(k, x, y)) return;
    const Mask mask = tree.masks[slot(tree, k, x, y)];
    const int h = 1 << (k - 1), c = (2 * x + 1) * h, r = (2 * y + 1) * h;
    const std::uint32_t centre = add(c, r);
    const auto count = [](int bits) { return std::popcount(static_cast<unsigned>(bits & kVertices)); };
    vertices += count(mask), unwanted += count(mask & ~(mask >> kWanted));
    std::array<std::uint32_t, 4> middles{};
    for (unsigned side = 0; side < 4; ++side) {
      if ((mask & bit_of(side)) == 0) {
        triangle(corners[side], corners[(side + 1) % 4], centre);
      } else {
        const int dc = side == east   ? h
                       : side == west ? -h
                                      : 0,
                  dr = side == north   ? h
                       : side == south ? -h
                                       : 0;
        middles[side] = shared(c + dc, r + dr);
      }
    }
    for (unsigned q = 0; q < 4; ++q) quarter(k, x, y, q, mask, corners, middles, centre, cull_level, sees);
  }

  /// Quarter q is at corner q, between side q and the side before.
  template <class Sees>
  void quarter(int k, int x, int y, unsigned q, Mask mask, const std::array<std::uint32_t, 4>& corners,
               const std::array<std::uint32_t, 4>& middles, std::uint32_t centre, int cull_level,
               const Sees& sees) {
    const unsigned before = (q + 3) % 4;
    const int cx = 2 * x + (q == 1 || q == 2 ? 1 : 0), cy = 2 * y + (q >= 2 ? 1 : 0);
    if (k > 1 && (tree.masks[slot(tree, k - 1, cx, cy)] & kCentre) != 0) {
      std::array<std::uint32_t, 4> inner{};
      inner[q] = corners[q];
      inner[(q + 1) % 4] = middles[q];
      inner[(q + 2) % 4] = centre;
      inner[before] = middles[before];
      square(k - 1, cx, cy, inner, cull_level, sees);
      return;
    }
    if ((mask & bit_of(q)) != 0) triangle(corners[q], middles[q], centre);
    if ((mask & bit_of(before)) != 0) triangle(middles[before], corners[q], centre);
  }

  const TileWindow& window;
  Tree& tree;
  LodTileMesh& mesh;
  std::vector<std::uint32_t>& numbers;
  std::vector<std::size_t>& used;
  int vertices = 0;  ///< of squares: a middle is two squares'
  int unwanted = 0;  ///< of them
};

template <class Sees>
double BisectionForest::append(const LodScene& scene, std::size_t tile, int cull_level, const Sees& sees,
                               LodMesh& mesh) {
  Tree& tree = trees_[tile];
  const TileWindow window(scene, scene.tiles[tile]);
  LodTileMesh out{tile, {}, {}};
  Emitter emitter(*this, window, tree, out);
  const int n = window.cells();
  out.vertices.reserve(tree.vertices + 4);
  out.triangles.reserve(2 * tree.vertices + 2);
  const std::array<std::uint32_t, 4> corners{emitter.shared(0, 0), emitter.shared(n, 0), emitter.shared(n, n),
                                             emitter.shared(0, n)};
  if (tree.levels > 0 && (tree.masks[slot(tree, tree.levels, 0, 0)] & kCentre) != 0) {
    emitter.square(tree.levels, 0, 0, corners, cull_level, sees);
  } else if (((scene.tiles[tile].area.x ^ scene.tiles[tile].area.y) & 1) == 0) {
    emitter.triangle(corners[0], corners[1], corners[2]);
    emitter.triangle(corners[0], corners[2], corners[3]);
  } else {
    emitter.triangle(corners[0], corners[1], corners[3]);
    emitter.triangle(corners[1], corners[2], corners[3]);
  }
  if (!out.triangles.empty()) mesh.tiles.push_back(std::move(out));
  return emitter.vertices == 0 ? 0 : static_cast<double>(emitter.unwanted) / emitter.vertices;
}

}  // namespace cairn
