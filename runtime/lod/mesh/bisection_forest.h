#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod_method.h"

namespace cairn {

/// The restricted quadtree triangulation of a whole scene [3; Pajarola 1998]: tiles of any levels are squares
/// of one hierarchy, so that a vertex on a border needs vertices on both sides of it and gets them.
///
/// Level k of a tile's window has squares of 2^k cells, (x, y) counted from the south-west. A square has a
/// centre and the middles of its four edges. A middle needs the centres of the squares on both sides of its
/// edge; a centre needs those two middles of the next larger square that are corners of its own.
///
/// Where a neighbour has no sample at a vertex, its mesh gets none: conform() splits a triangle of one cell
/// there. A tile's corners are vertices of all that touch it, as far as they have samples there.
class BisectionForest {
 public:
  enum Side : unsigned { south, east, north, west };
  static constexpr int kNeverCull = 16;  ///< a cull_level that no square has

  /// Finds the neighbours. Until the next call a tile is named by its number in this scene.
  void prepare(const LodScene& scene);
  std::uint64_t bytes() const;

  int levels(std::size_t tile) const { return trees_[tile].levels; }  ///< log2 of the window's cells

  /// Begins a mesh: no vertices but the tiles' corners.
  void begin();
  /// Adds the vertex and all that it needs, in other tiles too. REQUIRES: 1 <= k <= levels(tile).
  void enable_centre(std::size_t tile, int k, int x, int y);
  void enable_middle(std::size_t tile, int k, int x, int y, Side side);

  /// Whether the sample (c, r) of the window is a vertex. REQUIRES: it is not one of its corners.
  bool has(std::size_t tile, int c, int r) const;

  /// Appends a tile's triangles, without the squares that `sees(k, x, y)` says no to: a square of at least
  /// 2^cull_level cells, whose inside no other asks for. Each inner square is a fan around its centre.
  template <class Sees>
  void append(const LodScene& scene, std::size_t tile, int cull_level, const Sees& sees, LodMesh& mesh);

 private:
  static constexpr std::uint8_t kCentre = 1;
  static constexpr std::uint8_t bit_of(unsigned side) { return static_cast<std::uint8_t>(2u << side); }

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
    std::vector<std::uint8_t> masks;      ///< what is enabled of each square
    std::array<std::vector<Beside>, 4> beside;
    bool touched = false;
  };
  struct Emitter;

  static std::size_t slot(const Tree& tree, int k, int x, int y) {
    return tree.first[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (tree.levels - k)) +
           static_cast<std::size_t>(x);
  }
  void find_neighbours(const LodScene& scene);
  void enable_beyond(const Tree& tree, int k, int x, int y, Side side);
  void enable_corners_of_neighbours(std::size_t tile);

  std::vector<Tree> trees_;
  std::vector<std::uint32_t> numbers_;  ///< of the vertices of the tile that is being appended
  std::vector<std::size_t> numbered_;
};

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
    const std::uint8_t mask = tree.masks[slot(tree, k, x, y)];
    const int h = 1 << (k - 1), c = (2 * x + 1) * h, r = (2 * y + 1) * h;
    const std::uint32_t centre = add(c, r);
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
  void quarter(int k, int x, int y, unsigned q, std::uint8_t mask,
               const std::array<std::uint32_t, 4>& corners, const std::array<std::uint32_t, 4>& middles,
               std::uint32_t centre, int cull_level, const Sees& sees) {
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
};

template <class Sees>
void BisectionForest::append(const LodScene& scene, std::size_t tile, int cull_level, const Sees& sees,
                             LodMesh& mesh) {
  Tree& tree = trees_[tile];
  const TileWindow window(scene, scene.tiles[tile]);
  LodTileMesh out{tile, {}, {}};
  Emitter emitter(*this, window, tree, out);
  const int n = window.cells();
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
}

}  // namespace cairn
