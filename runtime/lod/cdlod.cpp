// The method `cdlod` (Strugar 2010, Continuous Distance-Dependent Level of Detail).
//
// A tile is a quadtree of nodes, all drawn as one grid of 32×32 cells. A level of detail is used up to a
// range of its own, twice that of the next finer one; a node or a quarter of a node is replaced by a finer
// one where its box is within the finer one's range. In the last third of a level's range every second vertex
// moves along the grid towards its neighbour, its height always that of the ground below it, so that at the
// end of the range the grid is the next coarser one: nothing jumps, and levels meet without cracks.
//
// The paper leaves the ranges to the user. Here vertices are kPixels · tolerance apart on the screen at the
// end of a range. The rule knows heights by the boxes only, so the method has no tolerance to keep.
//
// Departures: the range of a level must be large against its nodes, or a node may meet one two levels
// coarser, or one that has begun to morph itself. The paper asks the user to choose ranges that avoid it. The
// scene's tiles do not follow ranges either: one that is good enough is not refined, however near it is.
// Where squares do not meet for these reasons, triangles are split at the neighbour's vertices
// (grid_squares.h). A vertex inside a square stops short of its neighbour by one unit of the lattice, so that
// no triangle between rows that have collapsed and rows that have not turns over.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/grid_squares.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/lod/mesh/square_volumes.h"

namespace cairn {
namespace {

constexpr int kNodeLevel = 5;  ///< log2 of a node's cells
constexpr double kPixels = 4;
constexpr double kMorphStart = 2.0 / 3;  ///< of the way from the finer level's range to the level's own

/// What is kept of a tile: boxes down to the quarters of the finest nodes.
struct PreparedNodes {
  PreparedNodes(const LodScene& scene, const LodTile& tile, bool)
      : volumes(scene, tile, kNodeLevel - 1),
        positions(south_west_of(tile.source), lattice_width(tile.source.level) / (scene.tile_size - 1),
                  scene.tile_size, scene.ellipsoid) {}
  std::uint64_t bytes() const { return volumes.bytes() + positions.bytes(); }

  SquareVolumes volumes;
  GridPositions positions;
};

/// The ranges of a view.
class Ranges {
 public:
  Ranges(const LodScene& scene, const LodView& view)
      : eye_(camera_frame(view.view).position),
        per_degree_(scene.ellipsoid.equator_degree_m() * pixels_per_radian(view.view) /
                    (kPixels * view.tolerance_px)) {}

  const glm::dvec3& eye() const { return eye_; }
  /// Returns the range of grids with vertices so many lattice units apart.
  double range_m(std::int64_t spacing) const {
    return std::ldexp(static_cast<double>(spacing), -kLatticeLevel) * per_degree_;
  }
  /// Returns how far a vertex has moved towards its neighbour, 0 to 1.
  double morph(const glm::dvec3& place, std::int64_t spacing) const {
    const double end = range_m(spacing), start = end * (1 + kMorphStart) / 2;
    return std::clamp((glm::distance(place, eye_) - start) / (end - start), 0.0, 1.0);
  }

 private:
  glm::dvec3 eye_;
  double per_degree_;
};

/// Chooses the squares of one tile.
class NodeSelection {
 public:
  NodeSelection(TileSquares& tile, const Ranges& ranges) : tile_(tile), ranges_(ranges) {}

  void run() { visit(tile_.level(), 0, 0); }

 private:
  void draw(int k, int x, int y, int step_level) {
    if (tile_.is_seen(k, x, y)) tile_.take(k, x, y, step_level);
  }

  /// A node of 2^k cells.
  void visit(int k, int x, int y) {
    const int step = std::max(0, k - kNodeLevel);
    if (step == 0) return draw(k, x, y, 0);
    if (!tile_.is_seen(k, x, y)) return;
    const double finer_m = ranges_.range_m(tile_.window().spacing() << (step - 1));
    if (tile_.volume_of(k, x, y)->distance_m(ranges_.eye()) >= finer_m) return draw(k, x, y, step);
    for (int q = 0; q < 4; ++q) {
      const int qx = 2 * x + (q & 1), qy = 2 * y + (q >> 1);
      if (tile_.volume_of(k - 1, qx, qy)->distance_m(ranges_.eye()) < finer_m) {
        visit(k - 1, qx, qy);
      } else {
        draw(k - 1, qx, qy, step);
      }
    }
  }

  TileSquares& tile_;
  const Ranges& ranges_;
};

/// Returns the height of the bilinear surface at a point between the samples.
double bilinear_m(const TileWindow& window, const LatticePoint& point) {
  const LatticePoint corner = window.point(0, 0);
  const std::int64_t x = point.x - corner.x, y = point.y - corner.y, spacing = window.spacing();
  const int c = std::min(static_cast<int>(x / spacing), window.cells() - 1);
  const int r = std::min(static_cast<int>(y / spacing), window.cells() - 1);
  const double u = static_cast<double>(x - c * spacing) / static_cast<double>(spacing);
  const double v = static_cast<double>(y - r * spacing) / static_cast<double>(spacing);
  const double south = window.height_m(c, r) + u * (window.height_m(c + 1, r) - window.height_m(c, r));
  const double north =
      window.height_m(c, r + 1) + u * (window.height_m(c + 1, r + 1) - window.height_m(c, r + 1));
  return south + v * (north - south);
}

class Cdlod : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { nodes_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return nodes_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const Ranges ranges(scene, view);
    std::size_t tile = scene.tiles.size();
    const GridPositions* positions = nullptr;
    return build_of_squares(
        scene, view, [&](const LodTile& t) -> const SquareVolumes& { return nodes_.of(t).volumes; },
        [&](TileSquares& squares) { NodeSelection(squares, ranges).run(); },
        [&](const TileWindow& window, const GridSquare& square, int i, int j) {
          if (square.tile != tile) positions = &nodes_.of(scene.tiles[tile = square.tile]).positions;
          return morphed(window, square, i, j, *positions, ranges);
        });
  }

 private:
  /// Odd columns move to the west, odd rows to the south.
  static LodVertex morphed(const TileWindow& window, const GridSquare& square, int i, int j,
                           const GridPositions& positions, const Ranges& ranges) {
    const int column = square.column + i * square.step, row = square.row + j * square.step;
    const LodVertex vertex = window.vertex(column, row);
    if (((i | j) & 1) == 0 || square.across() == 1) return vertex;
    const std::int64_t spacing = square.step * window.spacing();
    const double morph =
        ranges.morph(positions.at(window.column() + column, window.row() + row, vertex.height_m), spacing);
    if (morph == 0) return vertex;
    const bool on_rim = i == 0 || j == 0 || i == square.across() || j == square.across();
    const std::int64_t moved =
        std::min(static_cast<std::int64_t>(morph * static_cast<double>(spacing)), spacing - (on_rim ? 0 : 1));
    const LatticePoint point{vertex.point.x - (i & 1) * moved, vertex.point.y - (j & 1) * moved};
    return {point, bilinear_m(window, point)};
  }

  PreparedTiles<PreparedNodes> nodes_;
};

}  // namespace

extern const LodMethodInfo cdlod_lod_method;
const LodMethodInfo cdlod_lod_method{"cdlod", false, create_without_options<Cdlod>};

}  // namespace cairn
