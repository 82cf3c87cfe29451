#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/lod/mesh/build_mesh.h"
#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {

/// The restricted quadtree triangulation of a whole scene (Pajarola 1998; Intel 2012, Algorithm 1). Tiles of
/// any levels are squares of one hierarchy, so a vertex on a border adds the vertices that it depends on in
/// the tiles on both sides.
///
/// Level k of a tile's window has squares of 2^k cells; (x, y) counts them from the south-west. A square has
/// a centre vertex and four middle vertices, one on each edge. A middle depends on the centres of the squares
/// on both sides of its edge. A centre depends on the two middles of the next larger square that are corners
/// of its own square.
///
/// A neighbour that has no sample at a border vertex gets no vertex there; remove_t_junctions() splits one of
/// its triangles of one cell instead. A tile's corners are vertices of every tile that touches it and has
/// samples there.
///
/// To build a mesh: prepare() once per scene, then begin(), enable or request vertices, refine() or
/// join_corners(), and append() each tile. One thread only.
class BisectionForest {
 public:
  enum Side : unsigned { south, east, north, west };
  static constexpr int kNeverCull = 16;  ///< a cull_level that no square reaches
  using Corner = std::array<int, 2>;     ///< (column, row) of a sample of a tile's window
  /// Three samples, anticlockwise; the right angle is at the last one.
  using Triangle = std::array<Corner, 3>;

  /// Finds each tile's neighbours. Until the next call, `tile` is an index into scene.tiles.
  void prepare(const LodScene& scene);
  std::uint64_t bytes() const;

  int levels(std::size_t tile) const { return trees_[tile].levels; }  ///< log2 of the window's cells

  /// For each tile 1 if a neighbour has a smaller sample spacing, so that it may have border vertices for
  /// which this tile has no sample; otherwise 0.
  const std::vector<char>& has_finer_neighbour() const { return has_finer_neighbour_; }

  /// Begins a mesh whose only vertices are each tile's own corners, and drops all requests.
  void begin();
  /// Adds the vertex and all vertices that it depends on, in other tiles too. REQUIRES: 1 <= k <=
  /// levels(tile).
  void enable_centre(std::size_t tile, int k, int x, int y);
  void enable_middle(std::size_t tile, int k, int x, int y, Side side);

  /// Requests the vertex: refine() adds it if the mesh comes to have a triangle that it bisects. Where the
  /// mesh keeps a larger triangle, the vertex is not added. REQUIRES: 1 <= k <= levels(tile).
  void request_centre(std::size_t tile, int k, int x, int y) { mark(tile, k, x, y, kCentre << kRequested); }
  void request_middle(std::size_t tile, int k, int x, int y, Side side) {
    mark(tile, k, x, y, static_cast<Mask>(bit_of(side) << kRequested));
  }
  /// Makes refine() add what is requested of the square without calling exceeds(). REQUIRES: 1 <= k <=
  /// levels(tile).
  void skip_exact_test(std::size_t tile, int k, int x, int y) { mark(tile, k, x, y, kSkipExactTest); }
  /// Ends a mesh: calls join_corners(), then bisects triangles at requested vertices until none is left.
  ///
  /// `select(tile, k, x, y)` is called once for each square in which the mesh comes to have triangles, larger
  /// squares first. It requests the vertices of the square, and returns true if it has requested those of all
  /// squares within it too; these are not visited then. `exceeds(tile, triangle)` is called once for each
  /// triangle with a requested vertex, unless its square skips the exact test; the triangle is bisected if it
  /// returns true.
  template <class Select, class Test>
  void refine(const Select& select, const Test& exceeds);
  /// Adds the corners that tiles have on their neighbours' borders, where these have samples. Ends a mesh
  /// whose vertices were all enabled, none requested.
  void join_corners();

  /// Returns whether sample (c, r) of the window is a vertex. REQUIRES: it is not a corner of the window.
  bool has(std::size_t tile, int c, int r) const;

  /// Appends a tile's triangles to the mesh, each square as a fan around its centre. Squares of at least
  /// 2^cull_level cells for which `is_visible(k, x, y)` returns false are left out.
  ///
  /// Returns the fraction (0 to 1) of the appended vertices that were not requested: they are there because
  /// another vertex depends on them. A middle counts once for each of its two squares.
  template <class IsVisible>
  double append(const LodScene& scene, std::size_t tile, int cull_level, const IsVisible& is_visible,
                LodMesh& mesh);

 private:
  /// One bit for each enabled vertex of a square; shifted by kRequested, for each requested one.
  using Mask = std::uint16_t;
  static constexpr Mask kCentre = 1;
  static constexpr Mask bit_of(unsigned side) { return static_cast<Mask>(2u << side); }
  static constexpr Mask kSkipExactTest = 1 << 5;  ///< requested vertices are added without a test
  static constexpr Mask kSelected = 1 << 6;       ///< select() was called for the square
  static constexpr Mask kAllSelected = 1 << 7;    ///< and it covered the squares within
  static constexpr Mask kVertices = 0x1f;         ///< the centre and the four middles
  static constexpr int kRequested = 8;
  static constexpr int kUntouched = 16;

  struct Neighbour {
    std::size_t tile;
    std::int64_t low;  ///< where its side begins along the border, in lattice units
    std::int64_t high;
  };
  struct Tree {
    int levels = 0;
    std::int64_t spacing = 0;
    LatticePoint corner;
    std::array<std::size_t, 16> first{};  ///< where each level's squares begin in masks
    std::vector<Mask> masks;
    std::array<std::vector<Neighbour>, 4> neighbours;
    int finest = kUntouched;   ///< the finest level with a mask other than 0
    std::size_t vertices = 0;  ///< how many are enabled
  };
  /// A new vertex, beside which triangles may have to be bisected.
  struct Pending {
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
  void add_pending(const Pending& square) {
    if (collects_pending_) pending_.push_back(square);
  }
  template <class Select>
  void select_once(std::size_t tile, int k, int x, int y, const Select& select);
  template <class Select, class Test>
  void bisect_at_edges(const Pending& centre, const Select& select, const Test& exceeds);
  template <class Select, class Test>
  void bisect_beside(const Pending& middle, const Select& select, const Test& exceeds);
  void enable_beyond(const Tree& tree, int k, int x, int y, Side side);
  void enable_corners_of_neighbours(std::size_t tile);

  std::vector<Tree> trees_;
  std::vector<char> has_finer_neighbour_;
  std::vector<Pending> pending_;
  bool collects_pending_ = false;
  std::vector<std::uint32_t> numbers_;  ///< by sample: the vertex number in the tile being appended
  std::vector<std::size_t> numbered_;   ///< the samples whose number is set
};

template <class Select, class Test>
void BisectionForest::refine(const Select& select, const Test& exceeds) {
  collects_pending_ = true;
  join_corners();
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    const int levels = trees_[i].levels;
    if (levels == 0) continue;
    select_once(i, levels, 0, 0, select);
    if ((trees_[i].masks.front() & kCentre << kRequested) != 0) enable_centre(i, levels, 0, 0);
  }
  while (!pending_.empty()) {
    const Pending next = pending_.back();
    pending_.pop_back();
    if (next.vertex == kCentre) {
      bisect_at_edges(next, select, exceeds);
    } else {
      bisect_beside(next, select, exceeds);
    }
  }
  collects_pending_ = false;
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

// A square whose centre is a vertex has one triangle at each edge whose middle is none.
template <class Select, class Test>
void BisectionForest::bisect_at_edges(const Pending& centre, const Select& select, const Test& exceeds) {
  const auto [tile, k, x, y, vertex] = centre;
  select_once(tile, k, x, y, select);
  const std::size_t at = slot(trees_[tile], k, x, y);
  const std::array<Corner, 4> corners = corners_of(k, x, y);
  const Corner middle = middle_of(corners[0], corners[2]);
  for (unsigned side = 0; side < 4; ++side) {
    const Mask mask = trees_[tile].masks[at];
    if ((mask >> kRequested & ~mask & bit_of(side)) == 0) continue;
    if ((mask & kSkipExactTest) != 0 ||
        exceeds(tile, Triangle{corners[side], corners[(side + 1) % 4], middle}))
      enable_middle(tile, k, x, y, static_cast<Side>(side));
  }
}

// On both sides of a middle lies a quarter of its square. Where the quarter's own centre is no vertex, one
// triangle covers the half of it beside the middle.
template <class Select, class Test>
void BisectionForest::bisect_beside(const Pending& middle, const Select& select, const Test& exceeds) {
  const auto [tile, k, x, y, vertex] = middle;
  const auto side = static_cast<unsigned>(std::countr_zero(vertex)) - 1;
  const std::array<Corner, 4> corners = corners_of(k, x, y);
  const Corner centre = middle_of(corners[0], corners[2]);
  const Corner at = middle_of(corners[side], corners[(side + 1) % 4]);
  for (const unsigned q : {side, (side + 1) % 4}) {
    const int cx = 2 * x + (q == 1 || q == 2 ? 1 : 0), cy = 2 * y + (q >= 2 ? 1 : 0);
    select_once(tile, k - 1, cx, cy, select);
    const Mask mask = trees_[tile].masks[slot(trees_[tile], k - 1, cx, cy)];
    if ((mask >> kRequested & ~mask & kCentre) == 0) continue;
    const Triangle half = q == side ? Triangle{centre, corners[q], at} : Triangle{corners[q], centre, at};
    if ((mask & kSkipExactTest) != 0 || exceeds(tile, half)) enable_centre(tile, k - 1, cx, cy);
  }
}

/// Appends one tile's triangles.
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
  /// Returns the number of a vertex that several squares share; adds it at the first call.
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

  /// Emits a square whose centre is a vertex; corners are anticlockwise from the south-west.
  template <class IsVisible>
  void square(int k, int x, int y, const std::array<std::uint32_t, 4>& corners, int cull_level,
              const IsVisible& is_visible) {
    if (k >= cull_level && !is_visible(k, x, y)) return;
    const Mask mask = tree.masks[slot(tree, k, x, y)];
    const int h = 1 << (k - 1), c = (2 * x + 1) * h, r = (2 * y + 1) * h;
    const std::uint32_t centre = add(c, r);
    const auto count = [](int bits) { return std::popcount(static_cast<unsigned>(bits & kVertices)); };
    vertices += count(mask), dependent += count(mask & ~(mask >> kRequested));
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
    for (unsigned q = 0; q < 4; ++q)
      quarter(k, x, y, q, mask, corners, middles, centre, cull_level, is_visible);
  }

  /// Emits quarter q, which lies at corner q, between side q and the side before it.
  template <class IsVisible>
  void quarter(int k, int x, int y, unsigned q, Mask mask, const std::array<std::uint32_t, 4>& corners,
               const std::array<std::uint32_t, 4>& middles, std::uint32_t centre, int cull_level,
               const IsVisible& is_visible) {
    const unsigned before = (q + 3) % 4;
    const int cx = 2 * x + (q == 1 || q == 2 ? 1 : 0), cy = 2 * y + (q >= 2 ? 1 : 0);
    if (k > 1 && (tree.masks[slot(tree, k - 1, cx, cy)] & kCentre) != 0) {
      std::array<std::uint32_t, 4> inner{};
      inner[q] = corners[q];
      inner[(q + 1) % 4] = middles[q];
      inner[(q + 2) % 4] = centre;
      inner[before] = middles[before];
      square(k - 1, cx, cy, inner, cull_level, is_visible);
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
  int vertices = 0;   ///< summed over squares, so that a middle counts twice
  int dependent = 0;  ///< those of them that were not requested
};

template <class IsVisible>
double BisectionForest::append(const LodScene& scene, std::size_t tile, int cull_level,
                               const IsVisible& is_visible, LodMesh& mesh) {
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
    emitter.square(tree.levels, 0, 0, corners, cull_level, is_visible);
  } else if (((scene.tiles[tile].area.x ^ scene.tiles[tile].area.y) & 1) == 0) {
    emitter.triangle(corners[0], corners[1], corners[2]);
    emitter.triangle(corners[0], corners[2], corners[3]);
  } else {
    emitter.triangle(corners[0], corners[1], corners[3]);
    emitter.triangle(corners[1], corners[2], corners[3]);
  }
  if (!out.triangles.empty()) mesh.tiles.push_back(std::move(out));
  return emitter.vertices == 0 ? 0 : static_cast<double>(emitter.dependent) / emitter.vertices;
}

/// Returns the mesh of the tiles that select() returns, once it has ended the forest's mesh. `append(tile,
/// mesh)` adds one tile.
template <class Select, class Append>
LodMesh mesh_of_forest(const LodScene& scene, const BisectionForest& forest, const Select& select,
                       const Append& append) {
  LodMesh mesh = build_mesh(scene, forest.has_finer_neighbour(), select,
                            [&](const std::vector<std::size_t>& drawn, LodMesh& built) {
                              for (const std::size_t tile : drawn) append(tile, built);
                            });
  mesh.count(IndexForm::list, {3 * mesh.triangle_count(), mesh.tiles.size()});
  return mesh;
}

}  // namespace cairn
