// The method `roam` (Duchaineau et al. 1997; Melkisetoğlu 2005, §4.2).
//
// A mesh is kept from frame to frame. Each vertex of the bisection hierarchy, the base of a diamond of two
// triangles, has a priority: its projected error over the tolerance. Two queues take the mesh from one
// frame's to the next one's: diamonds whose priority has risen above 1 are split, the largest first, with all
// splits that these force; diamonds whose priority has fallen to 1 or below are merged, the
// least first. So a frame's selection takes time for what changes, not for what there is.
//
// Most priorities need no look at all, for which the paper defers them: a vertex with error e has priority 1
// at one distance, so that its next look can wait until the camera has gone as far as it was from there. A
// calendar, ordered by the length of the camera's way, has the vertices to look at.
//
// Departures: errors and distances are those of nested spheres (Lindstrom & Pascucci 2001) over all samples
// instead of wedgies, so that the tolerance holds, and a diamond needs a split only if those above it do. The
// target is a tolerance, not a number of triangles: the queues are emptied in each frame. A priority does not
// know the direction of the view, so that turning the camera changes nothing, at the price of more triangles:
// each place is held to the tolerance as if it were in a corner of the viewport. What is outside the viewport
// is kept, and left out when the mesh is written. Writing it takes time for all triangles, which `building`
// has; the paper keeps strips.
//
// Guarantee: that of the method `soar`. The mesh depends on the scene, the view's place and the tolerance
// only, not on the frames before (tested).

#include <algorithm>
#include <cmath>
#include <memory>
#include <queue>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "runtime/lod/lod_method.h"
#include "runtime/lod/mesh/build_mesh.h"
#include "runtime/lod/mesh/nested_spheres.h"
#include "runtime/lod/mesh/prepared_tiles.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/lod/mesh/vertex_numbers.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {
namespace {

/// Triangles of fewer cells along their legs are not culled by themselves.
constexpr int kLeastCulled = 4;

/// A tile with the part of the mesh that is kept there.
struct RoamTile {
  RoamTile(const LodScene& scene, const LodTile& its_tile)
      : tile(its_tile),
        window(scene, tile),
        n(window.cells()),
        state((static_cast<std::size_t>(n) + 1) * (static_cast<std::size_t>(n) + 1), 0) {}

  std::uint8_t& at(int c, int r) {
    return state[static_cast<std::size_t>(r) * (static_cast<std::size_t>(n) + 1) +
                 static_cast<std::size_t>(c)];
  }
  bool is_corner(int c, int r) const { return (c == 0 || c == n) && (r == 0 || r == n); }
  bool is_on_border(int c, int r) const { return c == 0 || r == 0 || c == n || r == n; }

  LodTile tile;
  TileWindow window;
  int n;
  const NestedSpheres* spheres = nullptr;
  bool between_samples = false;
  std::vector<std::uint8_t> state;
};

constexpr std::uint8_t kOn = 1;         ///< it is a vertex of the mesh
constexpr std::uint8_t kPinned = 2;     ///< and must stay one
constexpr std::uint8_t kScheduled = 4;  ///< the calendar has it

/// A vertex of the hierarchy, as one of the tiles that share it has it.
struct Base {
  RoamTile* tile;
  int c;
  int r;

  std::uint8_t& state() const { return tile->at(c, r); }
  bool is_on() const { return tile->is_corner(c, r) || (state() & kOn) != 0; }
  int half() const { return (c | r) & -(c | r); }
  bool is_centre() const { return (c & half()) != 0 && (r & half()) != 0; }

  /// Calls use(base) for each vertex of the tile that this one depends on there.
  template <class Use>
  void for_parents(const Use& use) const {
    const int h = half();
    if (is_centre()) {
      if (2 * h == tile->n) return;
      for (const int dr : {-h, h}) {
        for (const int dc : {-h, h}) {
          if ((((c + dc) ^ (r + dr)) & (2 * h)) != 0) use(Base{tile, c + dc, r + dr});
        }
      }
      return;
    }
    const int dc = (c & h) != 0 ? 0 : h, dr = h - dc;
    for (const int sign : {-1, 1}) use_inside(c + sign * dc, r + sign * dr, use);
  }

  /// Calls use(base) for each vertex of the tile that depends on this one.
  template <class Use>
  void for_children(const Use& use) const {
    const int h = half();
    if (is_centre()) {
      for (const int sign : {-1, 1}) {
        use(Base{tile, c + sign * h, r});
        use(Base{tile, c, r + sign * h});
      }
      return;
    }
    if (h == 1) return;
    for (const int dr : {-h / 2, h / 2}) {
      for (const int dc : {-h / 2, h / 2}) use_inside(c + dc, r + dr, use);
    }
  }

 private:
  template <class Use>
  void use_inside(int column, int row, const Use& use) const {
    if (column >= 0 && row >= 0 && column <= tile->n && row <= tile->n) use(Base{tile, column, row});
  }
};

/// The tiles of a scene, by place.
class RoamTiles {
 public:
  using Kept = std::unordered_map<TileId, std::unique_ptr<RoamTile>>;

  Kept& kept() { return kept_; }
  RoamTile* of(const TileId& area) const { return kept_.at(area).get(); }

  void find_levels() {
    levels_.clear();
    for (const auto& [area, tile] : kept_) levels_.push_back(area.level);
    std::sort(levels_.begin(), levels_.end());
    levels_.erase(std::unique(levels_.begin(), levels_.end()), levels_.end());
  }

  /// Calls use(base) for the vertex as each tile has it that has the sample, its own first.
  template <class Use>
  void for_copies(const Base& base, const Use& use) const {
    use(base);
    if (base.tile->is_on_border(base.c, base.r))
      for_tiles_at(base.tile->window.point(base.c, base.r), base.tile, use);
  }

  /// Calls use(base) for the place as each tile but `except` has it that touches it and has the sample.
  template <class Use>
  void for_tiles_at(const LatticePoint& point, const RoamTile* except, const Use& use) const {
    RoamTile* seen[4] = {};
    for (int q = 0; q < 4; ++q) {
      RoamTile* other =
          containing(2 * point.x + ((q & 1) != 0 ? 1 : -1), 2 * point.y + ((q & 2) != 0 ? 1 : -1));
      if (!other || other == except || std::find(seen, seen + q, other) != seen + q) continue;
      seen[q] = other;
      const LatticePoint low = other->window.point(0, 0);
      const std::int64_t width = other->n * other->window.spacing();
      std::int64_t x = point.x - low.x, y = point.y - low.y;
      if (x < 0) x += kLatticeAround;
      if (x > width) x -= kLatticeAround;
      if (x % other->window.spacing() != 0 || y % other->window.spacing() != 0) continue;
      use(Base{other, static_cast<int>(x / other->window.spacing()),
               static_cast<int>(y / other->window.spacing())});
    }
  }

 private:
  /// Coordinates are doubled, so that the place is on no border.
  RoamTile* containing(std::int64_t twice_x, std::int64_t twice_y) const {
    if (twice_y < 0 || twice_y > 2 * kLatticePoleToPole) return nullptr;
    const std::int64_t x = ((twice_x >> 1) + kLatticeAround) % kLatticeAround, y = twice_y >> 1;
    for (const int level : levels_) {
      const std::int64_t width = lattice_width(level);
      const auto it =
          kept_.find({level, static_cast<std::int32_t>(x / width), static_cast<std::int32_t>(y / width)});
      if (it != kept_.end()) return it->second.get();
    }
    return nullptr;
  }

  Kept kept_;
  std::vector<int> levels_;
};

/// The mesh that is kept, its two queues and its calendar.
class Diamonds {
 public:
  /// Takes over what it has of tiles that stay, with new neighbours.
  void take_scene(const LodScene& scene, const PreparedTiles<NestedSpheres>& spheres) {
    if (!replace_tiles(scene, spheres)) return;
    tiles_.find_levels();
    drop_from_calendar();
    for (auto& [area, tile] : tiles_.kept()) {
      for (std::uint8_t& state : tile->state) state &= static_cast<std::uint8_t>(~kPinned);
    }
    for (auto& [area, tile] : tiles_.kept()) take_border(*tile);
    for (auto& [area, tile] : tiles_.kept()) pin(*tile);
  }

  /// Makes the mesh that of a camera's place. `allowed_per_m` is the vertical error that is within the
  /// tolerance at a distance of one metre.
  void refine(const glm::dvec3& eye, double allowed_per_m) {
    if (allowed_per_m != allowed_per_m_) begin_anew(eye, allowed_per_m);
    way_m_ += glm::distance(eye, eye_);
    eye_ = eye;
    look_at_due();
    while (!splits_.empty() || !merges_.empty() || !added_.empty()) {
      follow_added();
      if (!splits_.empty()) {
        const Base base = splits_.top().base;
        splits_.pop();
        enable(base);
      } else if (!merges_.empty()) {
        const Base base = merges_.top().base;
        merges_.pop();
        merge(base);
      }
    }
  }

  RoamTile& tile(const TileId& area) const { return *tiles_.of(area); }

  std::uint64_t bytes() const {
    std::uint64_t bytes = calendar_.size() * sizeof(Due);
    for (const auto& [area, tile] : const_cast<RoamTiles&>(tiles_).kept()) bytes += tile->state.size();
    return bytes;
  }

 private:
  struct Due {
    double way_m;
    Base base;
    bool operator<(const Due& other) const { return way_m > other.way_m; }  // the least first
  };
  struct Split {
    double priority;
    Base base;
    bool operator<(const Split& other) const { return priority < other.priority; }
  };
  struct Merge {
    double priority;
    Base base;
    bool operator<(const Merge& other) const { return priority > other.priority; }
  };
  /// How a vertex stands to the camera.
  struct Look {
    bool is_needed = false;
    double priority = 0;
    double slack_m = HUGE_VAL;  ///< the camera's least way to where is_needed changes
  };

  /// Returns false if the scene has the tiles that were here before.
  bool replace_tiles(const LodScene& scene, const PreparedTiles<NestedSpheres>& spheres) {
    RoamTiles::Kept kept;
    bool changed = false;
    for (const LodTile& tile : scene.tiles) {
      const auto known = tiles_.kept().find(tile.area);
      const NestedSpheres& its = spheres.of(tile);
      const bool stays = known != tiles_.kept().end() && known->second->tile.source == tile.source &&
                         known->second->tile.heights == tile.heights &&
                         known->second->tile.error_m == tile.error_m &&
                         known->second->between_samples == its.between_samples;
      std::unique_ptr<RoamTile>& slot = kept[tile.area];
      slot = stays ? std::move(known->second) : std::make_unique<RoamTile>(scene, tile);
      slot->spheres = &its;
      slot->between_samples = its.between_samples;
      changed |= !stays;
    }
    changed |= kept.size() != tiles_.kept().size();
    if (changed) {
      alive_.clear();
      for (const auto& [area, tile] : kept) alive_.push_back(tile.get());
      std::sort(alive_.begin(), alive_.end());
    }
    tiles_.kept() = std::move(kept);
    return changed;
  }

  void drop_from_calendar() {
    const auto is_gone = [&](const auto& entry) {
      return !std::binary_search(alive_.begin(), alive_.end(), entry.base.tile);
    };
    std::vector<Due> left;
    for (; !calendar_.empty(); calendar_.pop()) {
      if (!is_gone(calendar_.top())) left.push_back(calendar_.top());
    }
    calendar_ = std::priority_queue<Due>(std::less<Due>(), std::move(left));
    std::erase_if(added_, [&](const Base& base) {
      return !std::binary_search(alive_.begin(), alive_.end(), base.tile);
    });
    recheck_.clear();
  }

  /// A vertex on a border is one in all tiles that have it. What a tile that is gone had forced may be
  /// merged.
  void take_border(RoamTile& tile) {
    for (int i = 0; i <= tile.n; ++i) {
      for (const Base& base :
           {Base{&tile, i, 0}, Base{&tile, i, tile.n}, Base{&tile, 0, i}, Base{&tile, tile.n, i}}) {
        if (tile.is_corner(base.c, base.r) || (base.state() & kOn) == 0) continue;
        enable(base);
        recheck_.push_back(base);
      }
    }
  }

  /// A tile's centre is always a vertex, and its corners are in the tiles beside it.
  void pin(RoamTile& tile) {
    if (tile.n > 1) pin_one({&tile, tile.n / 2, tile.n / 2});
    for (const int r : {0, tile.n}) {
      for (const int c : {0, tile.n}) {
        tiles_.for_tiles_at(tile.window.point(c, r), &tile, [&](const Base& base) {
          if (!base.tile->is_corner(base.c, base.r)) pin_one(base);
        });
      }
    }
  }
  void pin_one(const Base& base) {
    enable(base);
    tiles_.for_copies(base, [](const Base& copy) { copy.state() |= kPinned; });
  }

  void begin_anew(const glm::dvec3& eye, double allowed_per_m) {
    allowed_per_m_ = allowed_per_m;
    eye_ = eye;
    way_m_ = 0;
    calendar_ = {};
    added_.clear(), recheck_.clear();
    for (auto& [area, tile] : tiles_.kept())
      std::fill(tile->state.begin(), tile->state.end(), std::uint8_t{0});
    for (auto& [area, tile] : tiles_.kept()) pin(*tile);
  }

  Look look_at(const Base& base) const {
    Look look;
    tiles_.for_copies(base, [&](const Base& copy) {
      const RoamTile& tile = *copy.tile;
      if (tile.is_corner(copy.c, copy.r)) return;
      const int column = tile.window.column() + copy.c, row = tile.window.row() + copy.r;
      const std::size_t i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.tile.heights->size) +
          static_cast<std::size_t>(column);
      const double error_m = static_cast<double>(tile.spheres->errors_m[i]);
      const double distance_m =
          glm::distance(eye_, tile.spheres->positions.at(column, row, tile.window.height_m(copy.c, copy.r))) -
          static_cast<double>(tile.spheres->radii_m[i]);
      // ScreenErrorBudget::error_m() allows max(all − tile, all/4), with all in proportion to the distance.
      const double enough_m = std::min(error_m + tile.tile.error_m, 4 * error_m) / allowed_per_m_;
      look.is_needed |= distance_m <= 0 || distance_m < enough_m;
      look.priority = std::max(look.priority, enough_m / std::max(distance_m, 1e-3));
      look.slack_m = std::min(look.slack_m, std::abs(distance_m - std::max(enough_m, 0.0)));
    });
    return look;
  }

  void schedule(const Base& base, const Look& look) {
    if ((base.state() & kScheduled) != 0) return;
    base.state() |= kScheduled;
    calendar_.push({way_m_ + look.slack_m, base});
  }

  /// Puts a vertex into the queue that it belongs to, or back into the calendar.
  void look_again(const Base& base) {
    const Look look = look_at(base);
    if (base.is_on()) {
      if (!look.is_needed) merges_.push({look.priority, base});
      schedule(base, look);
      return;
    }
    bool is_candidate = false;
    tiles_.for_copies(base, [&](const Base& copy) {
      if (copy.tile->is_corner(copy.c, copy.r)) return;
      copy.for_parents([&](const Base& parent) { is_candidate |= parent.is_on(); });
    });
    if (!is_candidate) return;
    if (look.is_needed) splits_.push({look.priority, base});
    schedule(base, look);
  }

  void look_at_due() {
    for (const Base& base : recheck_) look_again(base);
    recheck_.clear();
    std::vector<Base> due;
    for (; !calendar_.empty() && calendar_.top().way_m <= way_m_; calendar_.pop()) {
      due.push_back(calendar_.top().base);
      due.back().state() &= static_cast<std::uint8_t>(~kScheduled);
    }
    for (const Base& base : due) look_again(base);
  }

  /// Splits the diamond and those that this forces.
  void enable(const Base& base) {
    bool is_new = false;
    tiles_.for_copies(base, [&](const Base& copy) {
      if (copy.is_on()) return;
      copy.state() |= kOn;
      is_new = true;
      copy.for_parents([&](const Base& parent) { enable(parent); });
    });
    if (is_new) added_.push_back(base);
  }

  /// New vertices bring forth triangles, which may have to be split too.
  void follow_added() {
    while (!added_.empty()) {
      const Base base = added_.back();
      added_.pop_back();
      look_again(base);
      tiles_.for_copies(base, [&](const Base& copy) {
        if (copy.tile->is_corner(copy.c, copy.r)) return;
        copy.for_children([&](const Base& child) {
          if (!child.is_on()) look_again(child);
        });
      });
    }
  }

  void merge(const Base& base) {
    if (!base.is_on() || (base.state() & kPinned) != 0) return;
    const Look look = look_at(base);
    bool has_children = false;
    tiles_.for_copies(base, [&](const Base& copy) {
      if (copy.tile->is_corner(copy.c, copy.r)) return;
      copy.for_children([&](const Base& child) { has_children |= child.is_on(); });
    });
    if (look.is_needed || has_children) return;
    tiles_.for_copies(base, [](const Base& copy) {
      if (!copy.tile->is_corner(copy.c, copy.r)) copy.state() &= static_cast<std::uint8_t>(~kOn);
    });
    schedule(base, look);
    tiles_.for_copies(base, [&](const Base& copy) {
      if (copy.tile->is_corner(copy.c, copy.r)) return;
      copy.for_parents([&](const Base& parent) {
        if (parent.tile->is_corner(parent.c, parent.r) || (parent.state() & kPinned) != 0) return;
        const Look above = look_at(parent);
        if (!above.is_needed) merges_.push({above.priority, parent});
      });
    });
  }

  RoamTiles tiles_;
  std::vector<const RoamTile*> alive_;  ///< sorted
  std::priority_queue<Due> calendar_;
  std::priority_queue<Split> splits_;
  std::priority_queue<Merge> merges_;
  std::vector<Base> added_;    ///< whose children were not looked at yet
  std::vector<Base> recheck_;  ///< which may have lost what depended on them
  glm::dvec3 eye_{0};
  double way_m_ = 0;  ///< that the camera has gone
  double allowed_per_m_ = -1;
};

class Roam : public LodMethod {
 public:
  void prepare(const LodScene& scene) override {
    spheres_.prepare(scene);
    diamonds_.take_scene(scene, spheres_);
    find_coarser_beside_finer(scene);
  }
  std::uint64_t prepared_bytes() const override { return spheres_.bytes() + diamonds_.bytes(); }

  LodMesh build(const LodScene& scene, const LodView& view) override {
    const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
    const auto select = [&] {
      diamonds_.refine(camera_frame(view.view).position, budget.error_m(budget.scale_from(1), 0, 0));
      return tiles_in_view(scene, view);
    };
    LodMesh mesh =
        build_mesh(scene, lacking_, select, [&](const std::vector<std::size_t>& drawn, LodMesh& out) {
          for (const std::size_t i : drawn) append(scene, i, view.cull ? &budget : nullptr, out);
        });
    mesh.count(IndexForm::list, {3 * mesh.triangle_count(), mesh.tiles.size()});
    return mesh;
  }

 private:
  struct Corner {
    int c;
    int r;
  };

  /// Bisects from the tile's four triangles around its centre down to the vertices that are in the mesh.
  void append(const LodScene& scene, std::size_t i, const ScreenErrorBudget* budget, LodMesh& mesh) {
    RoamTile& tile = diamonds_.tile(scene.tiles[i].area);
    LodTileMesh& out = mesh.tiles.emplace_back(LodTileMesh{i, {}, {}});
    numbers_.begin(tile.window, out);
    const int n = tile.n;
    const Corner sw{0, 0}, se{n, 0}, ne{n, n}, nw{0, n}, centre{n / 2, n / 2};
    if (n == 1) {
      bisect(tile, ne, sw, se, nullptr, out);
      bisect(tile, sw, ne, nw, nullptr, out);
      return;
    }
    bisect(tile, sw, se, centre, budget, out);
    bisect(tile, se, ne, centre, budget, out);
    bisect(tile, ne, nw, centre, budget, out);
    bisect(tile, nw, sw, centre, budget, out);
  }

  // The right angle is at `apex`; the corners are anticlockwise. Where nothing under a triangle is visible,
  // its vertices are left out.
  void bisect(RoamTile& tile, const Corner& from, const Corner& to, const Corner& apex,
              const ScreenErrorBudget* budget, LodTileMesh& out) {
    const int c = from.c + to.c, r = from.r + to.r;
    const Corner base{c / 2, r / 2};
    if (((c | r) & 1) != 0 || (tile.at(base.c, base.r) & kOn) == 0 ||
        (budget && is_hidden(tile, base, *budget))) {
      out.triangles.push_back(
          {numbers_.number(from.c, from.r), numbers_.number(to.c, to.r), numbers_.number(apex.c, apex.r)});
      return;
    }
    bisect(tile, apex, from, base, budget, out);
    bisect(tile, to, apex, base, budget, out);
  }

  static bool is_hidden(const RoamTile& tile, const Corner& base, const ScreenErrorBudget& budget) {
    if (((base.c | base.r) & -(base.c | base.r)) < kLeastCulled) return false;
    const int column = tile.window.column() + base.c, row = tile.window.row() + base.r;
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.tile.heights->size) +
                          static_cast<std::size_t>(column);
    return !budget.may_be_visible(
        {tile.spheres->positions.at(column, row, tile.window.height_m(base.c, base.r)),
         static_cast<double>(tile.spheres->radii_m[i])});
  }

  void find_coarser_beside_finer(const LodScene& scene) {
    lacking_.assign(scene.tiles.size(), 0);
    for (std::size_t i = 0; i < scene.tiles.size(); ++i) {
      const LodTile& tile = scene.tiles[i];
      for (const LodTile& other : scene.tiles) {
        if (other.source.level > tile.source.level && touch(tile.area, other.area)) lacking_[i] = 1;
      }
    }
  }

  static bool touch(const TileId& a, const TileId& b) {
    const LatticePoint p = south_west_of(a), q = south_west_of(b);
    const std::int64_t wide = lattice_width(a.level), other = lattice_width(b.level);
    if (q.y > p.y + wide || p.y > q.y + other) return false;
    const std::int64_t east = (q.x - p.x + kLatticeAround) % kLatticeAround;
    return east <= wide || kLatticeAround - east <= other;
  }

  PreparedTiles<NestedSpheres> spheres_;
  Diamonds diamonds_;
  std::vector<char> lacking_;
  VertexNumbers numbers_;
};

}  // namespace

extern const LodMethodInfo roam_lod_method;
const LodMethodInfo roam_lod_method{"roam", true, create_without_options<Roam>};

}  // namespace cairn
