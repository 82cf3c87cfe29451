#include "runtime/surface/lod_transition.h"

#include <algorithm>
#include <map>
#include <memory>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr double kQuantum_m = 0.25;
constexpr int kLongestFade = 120;

/// Lists of tiles of one surface, and what is prepared of them.
class World {
 public:
  RenderTile tile(const TileId& id) {
    RenderTile tile;
    tile.area = tile.heights_id = id;
    tile.heights = heights(id);
    tile.visible = true;
    const GeoBounds b = tile_bounds(id);
    tile.volume = bounding_volume(b, 0, 4000, Occluder(0));
    return tile;
  }
  RenderList list(const std::vector<TileId>& ids) {
    RenderList list;
    for (const TileId& id : ids) list.tiles.push_back(tile(id));
    return list;
  }
  const SurfaceTile* surface(const RenderTile& tile) {
    auto& slot = surfaces_[tile.heights_id];
    if (!slot) {
      slot = std::make_unique<SurfaceTile>(
          prepare_surface_tile(tile.heights_id, tile.heights, kQuantum_m, false, {}));
    }
    return slot.get();
  }
  std::span<const ShownTile> update(LodTransition& shown, const RenderList& list, double distance_m) {
    // Above the middle of the parent.
    const BoundingVolume volume = tile(kParent).volume;
    const FrameScale scale{volume.centre + glm::normalize(volume.centre) * distance_m, 1000, 1, kLongestFade};
    return shown.update(list, scale, [this](const RenderTile& t) { return surface(t); });
  }

  static constexpr TileId kParent{0, 190, 100};

 private:
  std::shared_ptr<const HeightTile> heights(const TileId& id) {
    auto& slot = heights_[id];
    if (!slot) slot = std::make_shared<const HeightTile>(surface_.tile(id));
    return slot;
  }
  test::TestSurface surface_{257, 3, test::hills, {}};
  std::map<TileId, std::shared_ptr<const HeightTile>> heights_;
  std::map<TileId, std::unique_ptr<SurfaceTile>> surfaces_;
};

std::vector<TileId> children() {
  std::vector<TileId> ids;
  for (int q = 0; q < 4; ++q) ids.push_back(child_of(World::kParent, q));
  return ids;
}

/// Frames until nothing moves any more.
int frames_to_settle(World& world, LodTransition& shown, const RenderList& list, double distance_m) {
  for (int i = 1; i < 10000; ++i) {
    const auto tiles = world.update(shown, list, distance_m);
    const bool settled = std::none_of(tiles.begin(), tiles.end(), [](const ShownTile& t) { return t.moves; });
    if (settled && tiles.size() == list.tiles.size()) return i;
  }
  return -1;
}

}  // namespace

TEST_CASE(
    "a finer tile begins as the coarser one and gains detail, without end only where the eye is in it") {
  World world;
  LodTransition shown;
  const RenderList coarse = world.list({World::kParent}), fine = world.list(children());
  REQUIRE(world.update(shown, coarse, 3e5).size() == 1);
  CHECK(!shown.tiles()[0].moves);
  auto tiles = world.update(shown, fine, 3e5);
  REQUIRE(tiles.size() == 4);
  for (const ShownTile& tile : tiles) {
    CHECK(tile.detail == 0);
    CHECK(tile.moves);
  }
  tiles = world.update(shown, fine, 3e5);
  CHECK(tiles[0].detail > 0);
  CHECK(frames_to_settle(world, shown, fine, 3e5) < kLongestFade);
  for (const ShownTile& tile : shown.tiles()) CHECK(tile.detail == 1);
}

TEST_CASE("far away an exchange takes two frames, beside the eye the longest time that it may take") {
  World world;
  for (const double distance : {1e9, 0.0}) {
    LodTransition shown;
    world.update(shown, world.list({World::kParent}), distance);
    const int frames = frames_to_settle(world, shown, world.list(children()), distance);
    CAPTURE(distance);
    if (distance > 0) {
      CHECK(frames == 3);  // as it was; all at once; at rest
    } else {
      CHECK(frames >= kLongestFade);
      CHECK(frames <= kLongestFade + 3);
    }
  }
}

TEST_CASE("tiles that a coarser one replaces are shown until they have lost their detail") {
  World world;
  LodTransition shown;
  const RenderList coarse = world.list({World::kParent}), fine = world.list(children());
  world.update(shown, fine, 3e5);
  double previous = 1;
  int frames = 0;
  while (world.update(shown, coarse, 3e5).size() == 4) {
    REQUIRE(++frames < kLongestFade + 3);
    CHECK(shown.tiles()[0].detail <= previous);
    previous = shown.tiles()[0].detail;
  }
  CHECK(frames >= 2);
  CHECK(previous == 0);
  REQUIRE(shown.tiles().size() == 1);
  CHECK(shown.tiles()[0].detail == 0);
}

TEST_CASE("what was not visible, and what a cut parts from the last frame, is shown with all its detail") {
  World world;
  LodTransition shown;
  RenderList coarse = world.list({World::kParent});
  const RenderList fine = world.list(children());
  SECTION("not visible") {
    coarse.tiles[0].visible = false;
  }
  SECTION("a cut") {}
  world.update(shown, coarse, 3e5);
  if (coarse.tiles[0].visible) shown.cut();
  for (const ShownTile& tile : world.update(shown, fine, 3e5)) {
    CHECK(tile.detail == 1);
    CHECK(!tile.moves);
  }
}

}  // namespace cairn
