// Tiles by error, against what a view really shows of their errors.

#include "runtime/paging/tile_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "cairn/geodesy.h"
#include "format/pack_writer.h"
#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

using test::FlightPack;

class Picker {
 public:
  explicit Picker(const std::shared_ptr<const PackReader>& pack)
      : contents(pack), occluder(contents.lowest_m()), tree(contents, occluder) {}

  TileSelection select(const std::vector<ViewState>& views, const SelectionRules& rules = {},
                       const TileCut& held = {}) const {
    std::vector<SelectionView> selection;
    for (const ViewState& view : views) {
      FocusTile focus(0, 0);
      selection.push_back(selection_view(view, contents, occluder, RefinementPattern::restricted, focus));
    }
    return select_tiles(tree, selection, rules, held);
  }

  TileAvailability contents;
  Occluder occluder;
  TileTree tree;
};

/// Where a point is on the screen, in pixels from its middle; false where it is outside the viewport.
bool project(const ViewState& view, const glm::dvec3& point, glm::dvec2& at) {
  const glm::dvec3 p = camera_frame(view).in_camera(point);
  const double f = view.viewport_height_px / (2 * std::tan(glm::radians(view.fov_y_deg) / 2));
  if (p.z <= 0) return false;
  at = {f * p.x / p.z, f * p.y / p.z};
  return std::abs(at.x) <= view.viewport_width_px / 2.0 && std::abs(at.y) <= view.viewport_height_px / 2.0;
}

std::vector<ViewState> random_views(int count) {
  std::mt19937_64 random(11);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<ViewState> views;
  for (int i = 0; i < count; ++i) {
    ViewState view;
    view.eye = {between(27, 30), between(36, 38)};
    view.height_m = std::exp(between(std::log(400.0), std::log(3e6)));
    view.heading_deg = between(-180, 180);
    view.pitch_deg = between(-90, 5);
    view.fov_y_deg = std::vector<double>{60, 10, 1}[random() % 3];
    view.viewport_width_px = 640;
    view.viewport_height_px = std::vector<int>{360, 1080, 2160}[random() % 3];
    views.push_back(view);
  }
  return views;
}

std::set<TileId> sources_of(const TileCut& cut) {
  std::set<TileId> sources;
  for (const CutNode& node : cut) {
    if (node.heights) sources.insert(node.heights->id);
  }
  return sources;
}

}  // namespace

TEST_CASE("no place in a view is farther on the screen from the finest heights than the limit") {
  const FlightPack pack;
  const Picker picker(pack.open());
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t measured = 0;
  for (const ViewState& view : random_views(40)) {
    for (const double limit_px : {0.5, 4.0}) {
      SelectionRules rules;
      rules.heights_px = limit_px;
      const TileSelection selection = picker.select({view}, rules);
      CHECK_FALSE(selection.is_limited);
      for (const CutNode& node : selection.cut) {
        const double error_m = shortfall_of(picker.tree, node).heights_m;
        const GeoBounds b = tile_bounds(node.area);
        for (int i = 0; error_m > 0 && i < 20; ++i) {
          const LonLat place{b.west + unit(random) * b.width(), b.south + unit(random) * b.height()};
          if (place.lon > 180 || place.lat > 90) continue;
          const double height_m = unit(random) * 60;  // the pack's heights
          glm::dvec2 drawn, moved;
          if (!project(view, to_geocentric(place, height_m), drawn)) continue;
          for (const double sign : {-1.0, 1.0}) {
            project(view, to_geocentric(place, height_m + sign * error_m), moved);
            const bool is_hidden = !ViewFrustum(view, picker.occluder).sees(node.volume);
            if (is_hidden) continue;
            ++measured;
            REQUIRE(glm::length(moved - drawn) <= limit_px);
          }
        }
      }
    }
  }
  CHECK(measured > 2000);
}

namespace {

/// The tiles of heights that a cut shows, and all above them.
std::set<TileId> selected_in(const TileCut& cut) {
  std::set<TileId> selected;
  for (TileId id : sources_of(cut)) {
    for (selected.insert(id); id.level > kMinLevel; selected.insert(id)) id = parent_of(id);
  }
  return selected;
}

/// Adds the tiles below one for which it is not good enough in their areas.
void add_needed(const Picker& picker, const SelectionView& view, const TileId& area,
                std::set<TileId>& needed) {
  needed.insert(area);
  const TileTree::Node& node = picker.tree.node(area);
  if (!node.has_finer_heights) return;
  const auto error_m = static_cast<double>(node.best.heights->geometric_error_m);
  const auto is_needed_in = [&](const TileId& part) {
    const BoundingVolume& volume = picker.tree.node(part).best.volume;
    if (view.frustum.sees(volume)) return view.scale.error_px(volume, error_m) > 0.5;
    return view.ring.contains(area) && view.scale.error_px_in_the_middle(volume, error_m) > 8;
  };
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (!is_valid(child) || !picker.contents.has(Layer::heights, child)) continue;
    if (is_needed_in(area) && is_needed_in(child)) add_needed(picker, view, child, needed);
  }
}

/// Adds the tiles that must be there for tiles that touch in a view to be two levels apart at most, until
/// there are no more.
void add_balance(const Picker& picker, const SelectionView& view, std::set<TileId>& selected) {
  for (std::size_t before = 0; before != selected.size();) {
    before = selected.size();
    for (const TileId& area : std::set<TileId>(selected)) {
      for (int step = 0; step < 9; ++step) {
        const TileId beside = neighbour_of(area, step % 3 - 1, step / 3 - 1);
        for (int level = kMinLevel; is_valid(beside) && level <= area.level - 2; ++level) {
          const TileId coarse = ancestor_of(beside, level);
          if (picker.contents.has(Layer::heights, coarse) &&
              view.frustum.sees(picker.tree.node(coarse).best.volume))
            selected.insert(coarse);
        }
      }
    }
  }
}

/// Whether two areas touch, across ±180°, too, but not only at a pole.
bool touch(const TileId& a, const TileId& b) {
  const GeoBounds p = without_overhang(tile_bounds(a)), q = without_overhang(tile_bounds(b));
  if (p.south > q.north || q.south > p.north) return false;
  for (const double turn : {-360.0, 0.0, 360.0}) {
    if (p.west <= q.east + turn && q.west + turn <= p.east) return true;
  }
  return false;
}

/// Whether a part of what a node shows, two levels above the tile of another that touches it, may be seen.
bool is_seen_beside(const Picker& picker, const ViewFrustum& view, const CutNode& fine,
                    const CutNode& coarse) {
  const TileId& tile = fine.heights->id;
  for (int step = 0; step < 9; ++step) {
    const TileId beside = neighbour_of(tile, step % 3 - 1, step / 3 - 1);
    if (!is_valid(beside)) continue;
    const TileId part = ancestor_of(beside, tile.level - 2);
    const bool is_of_coarse = part.level >= coarse.area.level
                                  ? ancestor_of(part, coarse.area.level) == coarse.area
                                  : ancestor_of(coarse.area, part.level) == part;
    if (is_of_coarse && view.sees(picker.tree.node(part).best.volume)) return true;
  }
  return false;
}

/// Detail down to level 4 at plain land, on both sides of ±180° and at a pole; the tiles are flat, their
/// errors are made up.
class DetailPack {
 public:
  DetailPack() {
    PackHeader header;
    header.tile_size = 257;
    Result<PackWriter> writer = PackWriter::create(dir_.path() / "detail.cairn", header);
    REQUIRE(writer.ok());
    add({kMinLevel, 0, 0}, *writer);
    REQUIRE(writer->finish("{}").ok());
    Result<PackReader> opened = PackReader::open(dir_.path() / "detail.cairn");
    REQUIRE(opened.ok());
    reader = std::make_shared<const PackReader>(std::move(*opened));
  }
  std::shared_ptr<const PackReader> reader;

 private:
  static bool is_detailed(const TileId& id) {
    const GeoBounds b = tile_bounds(id);
    return id.level <= -4 || b.touches({27, 36, 30, 38}) || b.touches({177, -18, 180, -14}) ||
           b.touches({-180, -18, -176, -14}) || (b.north >= 89 && id.level <= 2);
  }
  void add(const TileId& id, PackWriter& writer) {
    IndexEntry entry;
    entry.id = id;
    entry.flags = kConstant;
    entry.min_quanta = entry.max_quanta = 4 * ((id.x + id.y) % 300);
    entry.geometric_error_m = static_cast<float>(300 * tile_width_degrees(id.level));
    REQUIRE(writer.add(entry, {}).ok());
    for (int quadrant = 0; quadrant < 4 && id.level < 4; ++quadrant) {
      const TileId child = child_of(id, quadrant);
      if (is_valid(child) && is_detailed(child)) add(child, writer);
    }
  }
  test::TempDir dir_;
};

std::vector<ViewState> views_near(LonLat place, double degrees, int count) {
  std::vector<ViewState> views = random_views(count);
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> off(-degrees, degrees);
  for (ViewState& view : views) {
    view.eye = {std::remainder(place.lon + off(random), 360.0),
                std::clamp(place.lat + off(random), -90.0, 90.0)};
  }
  return views;
}

}  // namespace

TEST_CASE("a tile that is shown has samples at the corners of its area, in sight or not") {
  const FlightPack pack;
  const Picker picker(pack.open());
  constexpr int kLevels = 8;  // a tile of 257² has samples at the corners of its parts down to these
  for (const ViewState& view : random_views(40)) {
    FocusTile focus(0, 0);
    SelectionView eye =
        selection_view(view, picker.contents, picker.occluder, RefinementPattern::restricted, focus);
    eye.ring = SplitSet();
    for (const CutNode& node : select_tiles(picker.tree, {&eye, 1}, {}, {}).cut) {
      if (node.heights) REQUIRE(node.area.level - node.heights->id.level <= kLevels);
    }
  }
}

TEST_CASE("no tile is selected without need, and none that is needed is left out") {
  const FlightPack pack;
  const Picker picker(pack.open());
  for (const ViewState& view : random_views(40)) {
    FocusTile focus(0, 0);
    const SelectionView eye =
        selection_view(view, picker.contents, picker.occluder, RefinementPattern::restricted, focus);
    std::set<TileId> needed;
    add_needed(picker, eye, {kMinLevel, 0, 0}, needed);
    add_balance(picker, eye, needed);
    REQUIRE(selected_in(picker.select({view}).cut) == needed);
  }
}

TEST_CASE(
    "tiles that touch in a view show heights at most two levels apart, at ±180° and beside a pole, too") {
  const DetailPack pack;
  const Picker picker(pack.reader);
  std::size_t steps_of_two = 0;
  for (const LonLat& place : {LonLat{28.5, 37}, LonLat{180, -16}, LonLat{15, 89.7}}) {
    for (const ViewState& view : views_near(place, 1, 30)) {
      for (const std::uint64_t tiles : {60, 100000}) {
        SelectionRules rules;
        rules.budget_bytes = tiles * decoded_bytes_bound(IndexEntry{}, 257);
        const TileCut cut = picker.select({view}, rules).cut;
        const ViewFrustum frustum(view, picker.occluder);
        for (const CutNode& fine : cut) {
          for (const CutNode& coarse : cut) {
            const int apart = fine.heights->id.level - coarse.heights->id.level;
            if (apart < 2 || !touch(fine.area, coarse.area)) continue;
            if (!frustum.sees(coarse.volume) || !is_seen_beside(picker, frustum, fine, coarse)) continue;
            ++steps_of_two;
            INFO(to_string(fine.area) << " beside " << to_string(coarse.area));
            REQUIRE((apart == 2 || shortfall_of(picker.tree, coarse).heights_m == 0));
          }
        }
      }
    }
  }
  CHECK(steps_of_two > 100);
}

TEST_CASE("a taller picture, a longer lens and a smaller tolerance never show less in the middle") {
  const FlightPack pack;
  const Picker picker(pack.open());
  LonLat ahead{28.3, 36.7};  // where the middle of the view meets the ground, on tiles of every level
  while (picker.contents.nearest(Layer::heights, tile_at(ahead, FlightPack::kFinest))->id.level < 5)
    ahead.lon += 0.01;
  ViewState view;
  view.eye = {ahead.lon, ahead.lat - 0.15};
  view.height_m = 3000;
  view.pitch_deg = -10;
  const auto finest_ahead = [&](double fov_deg, int rows, double limit_px) {
    view.fov_y_deg = fov_deg;
    view.viewport_height_px = rows;
    SelectionRules rules;
    rules.heights_px = limit_px;
    for (const CutNode& node : picker.select({view}, rules).cut) {
      if (tile_at(ahead, node.area.level) == node.area) return node.heights->id.level;
    }
    return kMinLevel;
  };
  const int usual = finest_ahead(60, 1080, 4);
  CHECK(finest_ahead(60, 4320, 4) > usual);
  CHECK(finest_ahead(10, 1080, 4) > usual);
  CHECK(finest_ahead(60, 1080, 1) > usual);
  CHECK(finest_ahead(60, 108, 4) < usual);
}

TEST_CASE("several views get what each of them gets alone") {
  const FlightPack pack;
  const Picker picker(pack.open());
  const std::vector<ViewState> views = random_views(6);
  const TileCut both = picker.select(views).cut;
  for (const ViewState& view : views) {
    const ViewFrustum frustum(view, picker.occluder);
    for (const CutNode& alone : picker.select({view}).cut) {
      for (const CutNode& node : both) {
        const int level = std::min(node.area.level, alone.area.level);
        if (ancestor_of(node.area, level) != ancestor_of(alone.area, level)) continue;
        REQUIRE(node.area.level >= alone.area.level);
        if (frustum.sees(node.volume)) REQUIRE(node.heights->id.level >= alone.heights->id.level);
      }
    }
  }
}

TEST_CASE("a budget is held, and leaves no area worse than the first that it does not allow") {
  const FlightPack pack;
  const Picker picker(pack.open());
  const int size = picker.contents.pack().header().tile_size;
  for (const ViewState& view : random_views(20)) {
    const ScreenScale scale(view);
    double before = std::numeric_limits<double>::infinity();
    for (const std::uint64_t tiles : {1, 10, 40, 160}) {
      SelectionRules rules;
      rules.budget_bytes = tiles * decoded_bytes_bound(IndexEntry{}, size);
      const TileSelection selection = picker.select({view}, rules);
      CHECK(sources_of(selection.cut).size() <= tiles);
      double worst = 0;
      for (const CutNode& node : selection.cut) {
        if (!ViewFrustum(view, picker.occluder).sees(node.volume)) continue;
        worst = std::max(worst, scale.error_px(node.volume, shortfall_of(picker.tree, node).heights_m));
      }
      CHECK(worst <= before);
      CHECK((selection.is_limited || worst <= 0.5));
      before = worst;
    }
  }
}

TEST_CASE("a selection that is held is its own successor, and keeps what is a little better than needed") {
  const FlightPack pack;
  const Picker picker(pack.open());
  SelectionRules rules;
  rules.hold = 1.2;
  for (ViewState view : random_views(20)) {
    const TileCut first = picker.select({view}, rules).cut;
    const TileCut again = picker.select({view}, rules, first).cut;
    CHECK(sources_of(again) == sources_of(first));
    view.height_m *= 1.001;
    const TileCut higher = picker.select({view}, rules, first).cut;
    const TileCut back = picker.select({view}, rules, higher).cut;
    CHECK(sources_of(back) == sources_of(higher));
  }
}

TEST_CASE("imagery that needs to be finer does not load finer heights") {
  const test::TempDir dir;
  const LonLat place{10.3, 45.3};
  test::write_imagery_pack(dir.path() / "imagery.cairn", place, 3, 3);
  auto opened = PackReader::open(dir.path() / "imagery.cairn");
  REQUIRE(opened.ok());
  const Picker picker(std::make_shared<const PackReader>(std::move(*opened)));
  ViewState view;
  view.eye = place;
  view.height_m = 60000;
  view.pitch_deg = -90;
  const auto finest = [&](const SelectionRules& rules) {
    std::pair<int, int> levels{kMinLevel, kMinLevel};
    for (const CutNode& node : picker.select({view}, rules).cut) {
      if (node.heights) levels.first = std::max(levels.first, node.heights->id.level);
      if (node.imagery) levels.second = std::max(levels.second, node.imagery->id.level);
    }
    return levels;
  };
  SelectionRules rules;
  rules.heights_px = 100;
  rules.texel_px = 1;
  const auto [heights, imagery] = finest(rules);
  CHECK(imagery > heights);
  // 935 px / 60 km: a texel of level 1, 217 m, is 3.4 px wide, one of level 3 is 0.84.
  CHECK(imagery == 3);
  rules.texel_px = std::numeric_limits<double>::infinity();
  CHECK(finest(rules) == std::pair(heights, kMinLevel));
}

}  // namespace cairn
