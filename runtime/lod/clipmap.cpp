// The method `clipmap` (Losasso & Hoppe 2004, Geometry Clipmaps).
//
// Square rings of regular grids lie around the camera, each with twice the spacing of the one within. Towards
// its outer border a ring's heights change into those of the next one, over a tenth of its width, so that the
// two agree there. A ring is left out, and the next one filled, while the camera is higher above the ground
// than 0.4 times the ring's width. So the number of triangles depends on the viewport and the tolerance
// alone, not on the ground.
//
// How it lies on the globe: the rings are squares of longitude and latitude, on the grid of samples, snapped
// to every second vertex as in the paper. Towards the poles their cells narrow in metres, as samples do. A
// ring goes on across the antimeridian and ends at the poles. The outermost one goes around the world.
//
// The paper has about s = 1.25 W / (n tan(φ/2)) pixels between vertices, with W the viewport's width, φ its
// angle and n vertices along a ring. Here n follows from s = kPixels · tolerance. The rule knows no heights,
// so the method has no tolerance to keep.
//
// Departures: a ring has the samples of the scene's tiles, and no more where these are coarser. The paper
// fills the rings' borders with triangles without area; here triangles are split at the neighbour's vertices
// (grid_squares.h), which gives the surface without them. Each frame is worked out anew, where the paper
// updates a texture by the strips that came in.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/grid_squares.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/square_volumes.h"

namespace cairn {
namespace {

constexpr double kPixels = 4;
constexpr double kHighest = 0.4;  ///< of a ring's width: a camera that is higher above ground drops it
constexpr int kLeastHalf = 8;     ///< of a ring's width, in cells
constexpr int kLeastVolume = 4;   ///< log2 of the cells of the smallest squares that are culled
constexpr int kMostAcross = 32;   ///< cells of a grid that is culled as a whole
constexpr int kCoarsest = 31;     ///< log2 of the largest spacing, in lattice units, that divides the world

struct PreparedVolumes {
  PreparedVolumes(const LodScene& scene, const LodTile& tile, bool) : volumes(scene, tile, kLeastVolume) {}
  std::uint64_t bytes() const { return volumes.bytes(); }

  SquareVolumes volumes;
};

int log2_of(std::int64_t power) {
  return std::countr_zero(static_cast<std::uint64_t>(power));
}

/// The rings of a view. Ring g has vertices 2^g lattice units apart.
class Rings {
 public:
  Rings(const LodScene& scene, const LodView& view, double ground_m)
      : eye_x_(std::ldexp(view.view.eye.lon + 180, kLatticeLevel)),
        eye_y_(std::ldexp(view.view.eye.lat + 90, kLatticeLevel)),
        half_(half_width(view)) {
    for (const LodTile& tile : scene.tiles)
      finest_ = std::min(finest_, log2_of(TileWindow(scene, tile).spacing()));
    const double unit_m = std::ldexp(scene.ellipsoid.equator_degree_m(), -kLatticeLevel);
    const double above_m = view.view.height_m - ground_m;
    while (finest_ < kCoarsest &&
           above_m > kHighest * std::ldexp(2 * static_cast<double>(half_) * unit_m, finest_))
      ++finest_;
    while (last_ < kCoarsest && half_ << last_ < kLatticeAround / 2) ++last_;
    last_ = std::max(last_, finest_);
  }

  /// Returns the ring of a whole square, -1 if it lies in several. Those finer than `least` count as `least`.
  int ring_of(const LatticePoint& low, std::int64_t width, int least) const {
    for (int g = std::max(finest_, least); g < last_; ++g) {
      const std::int64_t x = around(2 * low.x + width - 2 * snapped(eye_x_, g), 2 * kLatticeAround);
      const std::int64_t y = 2 * low.y + width - 2 * snapped(eye_y_, g);
      const std::int64_t far = std::max(std::abs(x), std::abs(y)), reach = 2 * (half_ << g);
      if (far + width <= reach) return g;
      if (far - width < reach) return -1;
    }
    return last_;
  }

  /// Returns how much of a vertex's height is that of the next ring's surface, 0 to 1.
  double blend(const LatticePoint& point, int g) const {
    if (g >= last_) return 0;
    const double dx =
        std::remainder(static_cast<double>(point.x) - eye_x_, static_cast<double>(kLatticeAround));
    const double dy = static_cast<double>(point.y) - eye_y_;
    const double cells = std::ldexp(std::max(std::abs(dx), std::abs(dy)), -g);
    const double width = std::max(1.0, std::floor(static_cast<double>(half_) / 5));
    return std::clamp((cells - (static_cast<double>(half_) - width - 1)) / width, 0.0, 1.0);
  }

 private:
  /// Half of a ring's width in cells, an even number.
  static std::int64_t half_width(const LodView& view) {
    const double spacing_px = kPixels * view.tolerance_px;
    const double half_tangent = std::tan(glm::radians(view.view.fov_y_deg) / 2) *
                                view.view.viewport_width_px / view.view.viewport_height_px;
    const double vertices = 1.25 * view.view.viewport_width_px / (spacing_px * half_tangent);
    return std::max<std::int64_t>(kLeastHalf, 2 * static_cast<std::int64_t>(std::ceil(vertices / 4)));
  }
  /// Returns the nearest vertex of the next ring.
  static std::int64_t snapped(double eye, int g) {
    return static_cast<std::int64_t>(std::round(std::ldexp(eye, -g - 1))) * (std::int64_t{2} << g);
  }
  static std::int64_t around(std::int64_t x, std::int64_t world) {
    x = (x % world + world) % world;
    return x > world / 2 ? x - world : x;
  }

  double eye_x_;
  double eye_y_;
  std::int64_t half_;
  int finest_ = kCoarsest;
  int last_ = 0;  ///< the ring that goes around the world
};

/// Chooses the squares of one tile.
class RingSquares {
 public:
  RingSquares(TileSquares& tile, const Rings& rings) : tile_(tile), rings_(rings) {}

  void run() { visit(tile_.level(), 0, 0); }

 private:
  void visit(int k, int x, int y) {
    if (!tile_.is_seen(k, x, y)) return;
    const TileWindow& window = tile_.window();
    const int spacing = log2_of(window.spacing());
    const int ring = rings_.ring_of(window.point(x << k, y << k), window.spacing() << k, spacing);
    const int step = std::clamp(ring - spacing, 0, k);
    if (k == 0 || (ring >= 0 && 1 << (k - step) <= kMostAcross)) return tile_.take(k, x, y, step);
    for (int q = 0; q < 4; ++q) visit(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1));
  }

  TileSquares& tile_;
  const Rings& rings_;
};

/// Returns the height of the scene at a place, 0 where it has none.
double ground_m(const LodScene& scene, LonLat place) {
  for (const LodTile& tile : scene.tiles) {
    if (tile_at(place, tile.area.level) != tile.area) continue;
    const TileWindow window(scene, tile);
    const LatticePoint low = window.point(0, 0);
    const auto index = [&](double degrees, std::int64_t from) {
      const auto at = static_cast<std::int64_t>(std::ldexp(degrees, kLatticeLevel));
      return std::clamp(static_cast<int>((at - from) / window.spacing()), 0, window.cells());
    };
    return window.height_m(index(place.lon + 180, low.x), index(place.lat + 90, low.y));
  }
  return 0;
}

/// Returns the vertex of a ring with the height that it has there.
LodVertex blended(const TileWindow& window, const GridSquare& square, int i, int j, const Rings& rings) {
  const int column = square.column + i * square.step, row = square.row + j * square.step;
  LodVertex vertex = window.vertex(column, row);
  const std::int64_t spacing = square.step * window.spacing();
  const bool odd_x = (vertex.point.x & spacing) != 0, odd_y = (vertex.point.y & spacing) != 0;
  // Where a tile is as small as a cell, its neighbours are not to be had; its corners stay.
  if ((!odd_x && !odd_y) || window.cells() < 2 * square.step) return vertex;
  const double blend = rings.blend(vertex.point, log2_of(spacing));
  if (blend <= 0) return vertex;
  const int dx = odd_x ? square.step : 0, dy = odd_y ? square.step : 0;
  const double coarse_m =
      (window.height_m(column - dx, row - dy) + window.height_m(column + dx, row + dy)) / 2;
  vertex.height_m += blend * (coarse_m - vertex.height_m);
  return vertex;
}

class Clipmap : public LodMethod {
 public:
  void prepare(const LodScene& scene) override { volumes_.prepare(scene); }
  std::uint64_t prepared_bytes() const override { return volumes_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const Rings rings(scene, view, ground_m(scene, view.view.eye));
    return build_of_squares(
        scene, view, [&](const LodTile& t) -> const SquareVolumes& { return volumes_.of(t).volumes; },
        [&](TileSquares& squares) { RingSquares(squares, rings).run(); },
        [&](const TileWindow& window, const GridSquare& square, int i, int j) {
          return blended(window, square, i, j, rings);
        });
  }

 private:
  PreparedTiles<PreparedVolumes> volumes_;
};

}  // namespace

extern const LodMethodInfo clipmap_lod_method;
const LodMethodInfo clipmap_lod_method{"clipmap", false, create_without_options<Clipmap>};

}  // namespace cairn
