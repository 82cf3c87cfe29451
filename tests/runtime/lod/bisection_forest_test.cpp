// Which vertices a mesh comes to have of those that its squares want.

#include "runtime/lod/mesh/bisection_forest.h"

#include <memory>

#include <catch2/catch.hpp>

namespace cairn::test {
namespace {

constexpr int kSize = 9;
constexpr int kLevels = 3;

LodScene flat_tile() {
  auto heights = std::make_shared<HeightTile>();
  heights->size = kSize;
  heights->samples.assign(std::size_t{kSize} * kSize, 0);
  LodTile tile;
  tile.source = tile.area = {0, 186, 136};
  tile.heights = heights;
  return {kSize, 1, 0, {tile}};
}

/// The tile's centre, the middle of its southern side, and the centre of the square in its south-western
/// quarter, whose triangles are there only with that.
template <class Confirms>
BisectionForest settled(const LodScene& scene, int trusted_from, const Confirms& confirms) {
  BisectionForest forest;
  forest.prepare(scene);
  forest.begin();
  forest.settle(
      [&](std::size_t tile, int k, int x, int y) {
        if (k <= trusted_from) forest.trust(tile, k, x, y);
        if (k == kLevels) {
          forest.want_centre(tile, k, x, y);
          forest.want_middle(tile, k, x, y, BisectionForest::south);
        } else if (k == kLevels - 1 && x == 0 && y == 0) {
          forest.want_centre(tile, k, x, y);
        }
        return false;
      },
      confirms);
  return forest;
}

struct Wanted {
  bool centre, south, quarter;
};
Wanted wanted_of(const BisectionForest& forest) {
  return {forest.has(0, 4, 4), forest.has(0, 4, 0), forest.has(0, 2, 2)};
}

}  // namespace

TEST_CASE("what is wanted of a triangle is taken if that is confirmed") {
  const LodScene scene = flat_tile();
  const auto run = [&](bool says) {
    int asked = 0;
    const auto confirms = [&](std::size_t, const BisectionForest::Triangle&) { return ++asked, says; };
    const Wanted wanted = wanted_of(settled(scene, 0, confirms));
    CHECK(wanted.centre);
    CHECK(wanted.south == says);
    CHECK(wanted.quarter == says);
    return asked;
  };
  CHECK(run(true) == 2);
  CHECK(run(false) == 1);
}

TEST_CASE("what a trusted square wants is taken unasked, but only of triangles that are there") {
  const LodScene scene = flat_tile();
  const auto run = [&](int trusted_from, bool says) {
    int asked = 0;
    const auto confirms = [&](std::size_t, const BisectionForest::Triangle&) { return ++asked, says; };
    const Wanted wanted = wanted_of(settled(scene, trusted_from, confirms));
    CHECK(wanted.south == (says || trusted_from == kLevels));
    CHECK(wanted.quarter == wanted.south);
    return asked;
  };
  CHECK(run(kLevels, false) == 0);
  CHECK(run(kLevels - 1, false) == 1);
  CHECK(run(kLevels - 1, true) == 1);
}

TEST_CASE("a mesh begins without what squares of the one before were trusted with") {
  const LodScene scene = flat_tile();
  BisectionForest forest;
  forest.prepare(scene);
  const auto asked_when = [&](const auto& select) {
    int asked = 0;
    forest.begin();
    forest.settle(select, [&](std::size_t, const BisectionForest::Triangle&) { return ++asked, true; });
    return asked;
  };
  CHECK(asked_when([&](std::size_t tile, int, int, int) {
          forest.trust(tile, kLevels - 1, 0, 0);
          return true;
        }) == 0);
  CHECK(asked_when([&](std::size_t tile, int k, int x, int y) {
          forest.want_centre(tile, k, x, y);
          forest.want_middle(tile, k, x, y, BisectionForest::south);
          forest.want_centre(tile, k - 1, x, y);
          return true;
        }) == 2);
}

}  // namespace cairn::test
