#include "runtime/paging/tile_cut.h"

#include <random>
#include <unordered_set>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

/// Appends the areas below one in the order of a cut: a tile's children in its place.
void walk(const TileId& id, const std::unordered_set<TileId>& areas, TileCut& cover) {
  if (areas.contains(id)) {
    cover.push_back({id, {}, {}, {}});
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    if (is_valid(child_of(id, quadrant))) walk(child_of(id, quadrant), areas, cover);
  }
}

TileCut cover_of(const TileId& eye, RefinementPattern pattern) {
  std::unordered_set<TileId> areas;
  for (const SceneTile& tile : build_scene_map({eye, kMinLevel, pattern})) areas.insert(tile.area);
  TileCut cover;
  walk({kMinLevel, 0, 0}, areas, cover);
  REQUIRE(cover.size() == areas.size());
  return cover;
}

}  // namespace

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
