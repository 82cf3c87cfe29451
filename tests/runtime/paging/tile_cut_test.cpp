#include "runtime/paging/tile_cut.h"

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

TileCut cover_of(const TileId& eye, RefinementPattern pattern) {
  TileCut cover;
  for (const SceneTile& tile : build_scene_map({eye, kMinLevel, pattern}))
    cover.push_back({tile.area, {}, {}, {}});
  std::sort(cover.begin(), cover.end(),
            [](const CutNode& a, const CutNode& b) { return depth_first_before(a.area, b.area); });
  return cover;
}

/// A cover's tiles in the order of the definition: a tile's children in its place.
void walk(const TileId& id, const TileCut& cover, std::vector<TileId>& out) {
  const bool leaf = std::any_of(cover.begin(), cover.end(), [&](const CutNode& t) { return t.area == id; });
  if (leaf) {
    out.push_back(id);
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    if (is_valid(child_of(id, quadrant))) walk(child_of(id, quadrant), cover, out);
  }
}

}  // namespace

TEST_CASE("depth_first_before is the order of a walk of the tree") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const TileId eye =
        tile_at({static_cast<double>(random() % 360) - 180, static_cast<double>(random() % 180) - 90},
                static_cast<int>(random() % 10));
    const TileCut cover = cover_of(eye, RefinementPattern::restricted);
    std::vector<TileId> order;
    walk({kMinLevel, 0, 0}, cover, order);
    REQUIRE(order.size() == cover.size());
    for (std::size_t j = 0; j < order.size(); ++j) REQUIRE(order[j] == cover[j].area);
  }
}

TEST_CASE("the changes between two covers account for every tile of both") {
  std::mt19937_64 random(2);
  const auto eye = [&] {
    return tile_at({static_cast<double>(random() % 360) - 180, static_cast<double>(random() % 180) - 90},
                   static_cast<int>(random() % 12) - 4);
  };
  for (int i = 0; i < 300; ++i) {
    const TileCut before = cover_of(eye(), RefinementPattern::restricted),
                  after = cover_of(eye(), RefinementPattern::cross);
    std::size_t i_old = 0, i_new = 0;
    for (const CutChange& change : changes_between(before, after)) {
      while (i_old < change.old_first) REQUIRE(before[i_old++].area == after[i_new++].area);
      REQUIRE(i_new == change.new_first);
      REQUIRE((change.old_count == 1 || change.new_count == 1));
      const TileId whole = change.coarsens() ? after[i_new].area : before[i_old].area;
      for (std::size_t j = 0; j < change.old_count; ++j) {
        REQUIRE(ancestor_of(before[i_old++].area, whole.level) == whole);
      }
      for (std::size_t j = 0; j < change.new_count; ++j) {
        REQUIRE(ancestor_of(after[i_new++].area, whole.level) == whole);
      }
    }
    while (i_old < before.size()) REQUIRE(before[i_old++].area == after[i_new++].area);
    REQUIRE(i_new == after.size());
  }
}

TEST_CASE("a cover does not differ from itself, and does where a tile shows other data") {
  TileCut cover = cover_of({3, 1500, 900}, RefinementPattern::restricted);
  CHECK(changes_between(cover, cover).empty());
  TileCut other = cover;
  IndexEntry entry;
  entry.id = cover[7].area;
  other[7].heights = entry;
  const auto changes = changes_between(cover, other);
  REQUIRE(changes.size() == 1);
  CHECK(changes[0].old_first == 7);
  CHECK_FALSE(changes[0].refines());
  CHECK_FALSE(changes[0].coarsens());
}

}  // namespace cairn
