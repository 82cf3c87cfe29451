// The method `quadtree` (Melkisetoğlu 2005, §5, after Röttger et al. 1998). A node of edge d, whose middle is
// at the L1 distance l from the camera (eq. 5.3), is split while
//
//   f = l / (d C max(c, 1)) < 1                       (5.4)
//   f = l / (d C max(c d2, 1))                        (5.6), with roughness: d2 = max|dh| / d (5.5)
//   C_N = C / (1 + |cos θ|)^4 in C's place            (5.8), with angle compensation, θ the view's pitch
//
// down to nodes of 3×3 samples. Nodes are drawn as triangle fans around their middles, which leave out the
// middle of an edge where the neighbour has not been split (tables 5.2.1, 5.2.2). The axes of the L1 norm are
// east, north and up at the camera. C and c follow from the tolerance τ, with P pixels per radian: without
// roughness c = 1 and C = P/(8τ), so that nodes of 8τ px are split; with it C = P/(32τ) and c = 32, so that a
// node is split while its dh projects above τ or its edge above 32τ px. A node's dh is not below its
// children's.
//
// Departures, because the description leaves cracks: (a) a node is split where a neighbour of its size has a
// split child beside it, in its tile or in the next of its level, whatever f says (the source relies on C,
// and its frustum test breaks even that); (b) tiles of different levels are joined by remove_t_junctions();
// (c) a tile's root is always split. The rule bounds no error, so the method has no tolerance to keep.

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/build_mesh.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod/mesh/vertex_numbers.h"

namespace cairn {
namespace {

constexpr double kEdge_px = 8;
constexpr double kRoughEdge_px = 32;

/// A node of a tile's quadtree: its middle and half its edge, in samples of the tile's window.
struct Node {
  int column = 0;
  int row = 0;
  int half = 0;
};

/// Which nodes of a window are split, by their middles: the matrix of table 5.2.1. It is cleared flag by
/// flag, so that a frame costs what it splits.
class SplitMatrix {
 public:
  explicit SplitMatrix(int side) : side_(side) {
    flags_.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  }
  bool contains(const Node& n) const { return flags_[slot(n)] != 0; }
  bool insert(const Node& n) {
    if (contains(n)) return false;
    flags_[slot(n)] = 1;
    set_.push_back(slot(n));
    return true;
  }
  void clear() {
    for (const std::size_t i : set_) flags_[i] = 0;
    set_.clear();
  }
  std::size_t slot(const Node& n) const {
    return static_cast<std::size_t>(n.row) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(n.column);
  }
  std::uint64_t bytes() const { return flags_.size(); }

 private:
  int side_;
  std::vector<std::uint8_t> flags_;
  std::vector<std::size_t> set_;
};

/// What is worked out when a tile is loaded, and the flags of its nodes.
struct Prepared {
  TileId source;
  GridPositions positions;
  SplitMatrix split;
  std::vector<float> roughness_m;  ///< max|dh| of the node around each sample; empty without roughness
};

/// Returns eq. 5.5 of every node of a window, made no smaller than the children's.
class Roughness {
 public:
  explicit Roughness(const TileWindow& window) : window_(window), side_(window.cells() + 1) {
    values_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
  }

  std::vector<float> all(double quantum_m) && {
    if (window_.cells() >= 2) of({window_.cells() / 2, window_.cells() / 2, window_.cells() / 2}, quantum_m);
    return std::move(values_);
  }

 private:
  float of(const Node& n, double quantum_m) {
    double worst = deviation(n) * quantum_m;
    if (n.half > 1) {
      const int quarter = n.half / 2;
      for (const int dy : {-quarter, quarter}) {
        for (const int dx : {-quarter, quarter}) {
          worst = std::max(worst, static_cast<double>(of({n.column + dx, n.row + dy, quarter}, quantum_m)));
        }
      }
    }
    return values_[static_cast<std::size_t>(n.row) * static_cast<std::size_t>(side_) +
                   static_cast<std::size_t>(n.column)] = static_cast<float>(worst);
  }

  /// Returns the largest |dh| of the middles of the four edges and, by both diagonals, of the node.
  double deviation(const Node& n) const {
    const int w = n.column - n.half, e = n.column + n.half, s = n.row - n.half, t = n.row + n.half;
    const auto between = [&](int c0, int r0, int c1, int r1) {
      const double ends = static_cast<double>(window_.quanta(c0, r0)) + window_.quanta(c1, r1);
      return std::abs(ends / 2 - window_.quanta((c0 + c1) / 2, (r0 + r1) / 2));
    };
    return std::max({between(w, s, e, s), between(w, t, e, t), between(w, s, w, t), between(e, s, e, t),
                     between(w, s, e, t), between(w, t, e, s)});
  }

  const TileWindow& window_;
  int side_;
  std::vector<float> values_;
};

/// Decides whether a node is split, by eq. 5.4 to 5.9 and the frustum test.
class Criterion {
 public:
  Criterion(const LodScene& scene, const LodView& view, const LodOptions& options)
      : screen_(view.view),
        frame_(local_frame(view.view.eye)),
        frustum_(view.view, Occluder(scene.lowest_m, scene.ellipsoid)),
        cull_(view.cull),
        rough_(options.roughness) {
    detail_ = screen_.pixels_per_radian() / ((rough_ ? kRoughEdge_px : kEdge_px) * view.tolerance_px);
    if (options.angle_compensation) {
      detail_ /= std::pow(1 + std::abs(std::cos(glm::radians(view.view.pitch_deg))), 4);
    }
  }

  bool splits(const glm::dvec3& middle, double edge_m, double roughness_m) const {
    const glm::dvec3 to = middle - screen_.camera().position;
    const double l1 = std::abs(glm::dot(to, frame_.east)) + std::abs(glm::dot(to, frame_.north)) +
                      std::abs(glm::dot(to, frame_.up));
    const double weight = rough_ ? std::max(kRoughEdge_px * roughness_m / edge_m, 1.0) : 1;
    return l1 < edge_m * detail_ * weight;
  }

  /// Returns whether a node may be visible; `relief_m` is the range of its tile's heights.
  bool may_be_visible(const glm::dvec3& middle, double edge_m, double relief_m) const {
    const double radius_m = 0.75 * edge_m + relief_m;
    return !cull_ ||
           frustum_.sees({middle, {{radius_m, 0, 0}, {0, radius_m, 0}, {0, 0, radius_m}}, std::nullopt});
  }

 private:
  Screen screen_;
  LocalFrame frame_;
  ViewFrustum frustum_;
  bool cull_;
  bool rough_;
  double detail_ = 0;  // C or C_N
};

/// The split nodes of all tiles of a scene.
class SplitNodes {
 public:
  SplitNodes(const LodScene& scene, std::unordered_map<TileId, Prepared>& prepared) : scene_(scene) {
    for (std::size_t i = 0; i < scene.tiles.size(); ++i) {
      const LodTile& tile = scene.tiles[i];
      tiles_.emplace(tile.area, i);
      windows_.emplace_back(scene, tile);
      split_.push_back(&prepared.at(tile.area).split);
      split_.back()->clear();
    }
  }

  const TileWindow& window(std::size_t tile) const { return windows_[tile]; }

  bool contains(std::size_t tile, const Node& n) const { return split_[tile]->contains(n); }

  /// Splits the node, its ancestors, and the neighbours that must be split with them.
  void insert(std::size_t tile, const Node& n) {
    if (!split_[tile]->insert(n) || n.half * 2 == windows_[tile].cells()) return;
    const Node parent = parent_of(n);
    insert(tile, parent);
    const int dx = n.column > parent.column ? 1 : -1, dy = n.row > parent.row ? 1 : -1;
    for (const auto& [east, north] : {std::pair{dx, 0}, {0, dy}}) {
      std::size_t other = tile;
      Node beside = parent;
      if (find_beside(other, beside, east, north) == Beside::node) insert(other, beside);
    }
  }

  enum class Beside { node, foreign };
  /// Moves to the neighbour of the node's size. Returns foreign where none lies on a grid of this spacing.
  Beside find_beside(std::size_t& tile, Node& n, int east, int north) const {
    const int cells = windows_[tile].cells();
    const Node moved{n.column + 2 * n.half * east, n.row + 2 * n.half * north, n.half};
    const bool inside = moved.column > 0 && moved.column < cells && moved.row > 0 && moved.row < cells;
    if (!inside) {
      const auto it = tiles_.find(neighbour_of(scene_.tiles[tile].area, east, north));
      if (it == tiles_.end() || windows_[it->second].spacing() != windows_[tile].spacing()) {
        return Beside::foreign;
      }
      tile = it->second;
    }
    n = {(moved.column + cells) % cells, (moved.row + cells) % cells, n.half};
    return Beside::node;
  }

 private:
  /// Returns the parent. Nodes of half edge h have their middles at odd multiples of h.
  static Node parent_of(const Node& n) {
    const int edge = 2 * n.half;
    return {n.column / (2 * edge) * 2 * edge + edge, n.row / (2 * edge) * 2 * edge + edge, edge};
  }

  const LodScene& scene_;
  std::unordered_map<TileId, std::size_t> tiles_;
  std::vector<TileWindow> windows_;
  std::vector<SplitMatrix*> split_;
};

/// Draws a tile's split nodes as fans.
class Fans {
 public:
  Fans(const SplitNodes& split, std::size_t tile, VertexNumbers& numbers, LodMesh& mesh)
      : split_(split), tile_(tile), numbers_(numbers), mesh_(mesh) {
    mesh_.tiles.push_back({tile, {}, {}});
    numbers_.begin(split.window(tile), mesh_.tiles.back());
  }

  void draw() {
    const int cells = split_.window(tile_).cells();
    if (cells >= 2) return draw({cells / 2, cells / 2, cells / 2});
    emit(numbers_.number(0, 0), numbers_.number(1, 0), numbers_.number(1, 1));
    emit(numbers_.number(0, 0), numbers_.number(1, 1), numbers_.number(0, 1));
    mesh_.count(IndexForm::fan, {4, 1});
  }

 private:
  /// The places around a node's middle, anticlockwise from the middle of the south edge; odd ones are
  /// corners.
  static constexpr int kRing[8][2] = {{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}};

  void draw(const Node& n) {
    bool drawn_by_child[4] = {};  // the quadrants of corner 1, 3, 5, 7
    for (std::size_t q = 0; q < 4 && n.half > 1; ++q) {
      const auto& corner = kRing[2 * q + 1];
      const Node child{n.column + corner[0] * n.half / 2, n.row + corner[1] * n.half / 2, n.half / 2};
      drawn_by_child[q] = split_.contains(tile_, child);
      if (drawn_by_child[q]) draw(child);
    }
    bool left_out[8] = {};
    for (std::size_t i = 0; i < 8; i += 2) left_out[i] = !splits_edge(n, i);
    draw_fan(n, drawn_by_child, left_out);
  }

  bool splits_edge(const Node& n, std::size_t ring) const {
    std::size_t tile = tile_;
    Node beside = n;
    const auto found = split_.find_beside(tile, beside, kRing[ring][0], kRing[ring][1]);
    return found == SplitNodes::Beside::foreign || split_.contains(tile, beside);
  }

  void draw_fan(const Node& n, const bool (&drawn_by_child)[4], const bool (&left_out)[8]) {
    const auto number = [&](std::size_t ring) {
      return numbers_.number(n.column + kRing[ring % 8][0] * n.half, n.row + kRing[ring % 8][1] * n.half);
    };
    IndexCount fans;
    bool open = false;
    for (std::size_t i = 0; i < 8; ++i) {
      if (left_out[i]) continue;
      std::size_t next = i + 1;
      if (left_out[next % 8]) ++next;
      const bool skipped = drawn_by_child[i / 2];  // ring 2q to 2q+2 is quadrant q
      if (!skipped) {
        emit(numbers_.number(n.column, n.row), number(i), number(next));
        fans.indices += open ? 1 : 3;
        fans.parts += open ? 0 : 1;
      }
      open = !skipped;
    }
    mesh_.count(IndexForm::fan, fans);
  }

  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.tiles.back().triangles.push_back({a, b, c});
    mesh_.count(IndexForm::list, {3, 0});
  }

  const SplitNodes& split_;
  std::size_t tile_;
  VertexNumbers& numbers_;
  LodMesh& mesh_;
};

class Quadtree : public LodMethod {
 public:
  explicit Quadtree(const LodOptions& options) : options_(options) {}

  void prepare(const LodScene& scene) override {
    std::unordered_set<TileId> areas;
    for (const LodTile& tile : scene.tiles) areas.insert(tile.area);
    std::erase_if(prepared_, [&](const auto& item) { return !areas.contains(item.first); });
    for (const LodTile& tile : scene.tiles) {
      const auto it = prepared_.find(tile.area);
      if (it != prepared_.end() && it->second.source == tile.source) continue;
      prepared_.insert_or_assign(tile.area, make(scene, tile));
    }
  }

  std::uint64_t prepared_bytes() const override {
    std::uint64_t bytes = 0;
    for (const auto& [area, tile] : prepared_) {
      bytes += tile.positions.bytes() + tile.split.bytes() + tile.roughness_m.size() * sizeof(float);
    }
    return bytes;
  }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    std::vector<std::size_t> drawn;
    const auto select = [&] {
      SplitNodes split(scene, prepared_);
      drawn = tiles_in_view(scene, view);
      const Criterion criterion(scene, view, options_);
      for (const std::size_t index : drawn) refine(scene, index, criterion, split);
      return split;
    };
    return build_mesh(scene, select, [&](const SplitNodes& split, LodMesh& mesh) {
      for (const std::size_t index : drawn) Fans(split, index, numbers_, mesh).draw();
    });
  }

 private:
  Prepared make(const LodScene& scene, const LodTile& tile) const {
    const TileWindow window(scene, tile);
    return {tile.source,
            GridPositions(window.point(0, 0), window.spacing(), window.cells() + 1, scene.ellipsoid),
            SplitMatrix(window.cells() + 1),
            options_.roughness ? Roughness(window).all(scene.quantum_m) : std::vector<float>()};
  }

  void refine(const LodScene& scene, std::size_t index, const Criterion& criterion, SplitNodes& split) const {
    const TileWindow& window = split.window(index);
    if (window.cells() < 2) return;
    const Prepared& tile = prepared_.at(scene.tiles[index].area);
    const double sample_m = tile_width_degrees(scene.tiles[index].source.level) / (scene.tile_size - 1) *
                            scene.ellipsoid.equator_degree_m();
    const double relief_m = scene.tiles[index].max_m - scene.tiles[index].min_m;
    const auto visit = [&](auto self, const Node& n) -> void {
      const bool root = 2 * n.half == window.cells();
      const glm::dvec3 middle = tile.positions.at(n.column, n.row, window.height_m(n.column, n.row));
      const double rough_m =
          tile.roughness_m.empty() ? 0 : static_cast<double>(tile.roughness_m[tile.split.slot(n)]);
      const double edge_m = 2 * n.half * sample_m;
      const bool splits =
          criterion.may_be_visible(middle, edge_m, relief_m) && criterion.splits(middle, edge_m, rough_m);
      if (root || splits) split.insert(index, n);
      if (!splits || n.half == 1) return;
      const int quarter = n.half / 2;
      for (const int dy : {-quarter, quarter}) {
        for (const int dx : {-quarter, quarter}) self(self, {n.column + dx, n.row + dy, quarter});
      }
    };
    visit(visit, {window.cells() / 2, window.cells() / 2, window.cells() / 2});
  }

  LodOptions options_;
  std::unordered_map<TileId, Prepared> prepared_;
  VertexNumbers numbers_;
};

}  // namespace

extern const LodMethodInfo quadtree_lod_method;
const LodMethodInfo quadtree_lod_method{"quadtree", false,
                                        [](const LodOptions& options) -> std::unique_ptr<LodMethod> {
                                          return std::make_unique<Quadtree>(options);
                                        }};

}  // namespace cairn
