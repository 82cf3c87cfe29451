// Which of the requested vertices BisectionForest adds.

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

/// Refines a mesh for which the tile's centre, the middle of its southern side, and the centre of its
/// south-western quarter are requested; the quarter has a triangle only once that middle is a vertex. Squares
/// of up to 2^skip_level cells skip the exact test.
template <class Exceeds>
BisectionForest refined(const LodScene& scene, int skip_level, const Exceeds& exceeds) {
  BisectionForest forest;
  forest.prepare(scene);
  forest.begin();
  forest.refine(
      [&](std::size_t tile, int k, int x, int y) {
        if (k <= skip_level) forest.skip_exact_test(tile, k, x, y);
        if (k == kLevels) {
          forest.request_centre(tile, k, x, y);
          forest.request_middle(tile, k, x, y, BisectionForest::south);
        } else if (k == kLevels - 1 && x == 0 && y == 0) {
          forest.request_centre(tile, k, x, y);
        }
        return false;
      },
      exceeds);
  return forest;
}

struct Vertices {
  bool centre, south, quarter;
  bool operator==(const Vertices&) const = default;
};
Vertices vertices_of(const BisectionForest& forest) {
  return {forest.has(0, 4, 4), forest.has(0, 4, 0), forest.has(0, 2, 2)};
}

/// Whether the triangle's right angle is at the tile's centre: one of the four below the tile's root.
bool is_at_centre(const BisectionForest::Triangle& triangle) {
  return triangle[2] == BisectionForest::Corner{4, 4};
}

const auto always = [](std::size_t, const BisectionForest::Triangle&) { return true; };
const auto never = [](std::size_t, const BisectionForest::Triangle&) { return false; };

}  // namespace

TEST_CASE("a requested vertex is added if the triangle that it bisects exceeds the tolerance") {
  const LodScene scene = flat_tile();
  CHECK(vertices_of(refined(scene, 0, always)) == Vertices{true, true, true});
  CHECK(vertices_of(refined(scene, 0, never)) == Vertices{true, false, false});
  const auto only_large = [](std::size_t, const BisectionForest::Triangle& t) { return is_at_centre(t); };
  CHECK(vertices_of(refined(scene, 0, only_large)) == Vertices{true, true, false});
}

TEST_CASE("a vertex whose triangle the mesh has not is not added, whatever is requested") {
  const LodScene scene = flat_tile();
  const auto only_small = [](std::size_t, const BisectionForest::Triangle& t) { return !is_at_centre(t); };
  CHECK(vertices_of(refined(scene, 0, only_small)) == Vertices{true, false, false});
}

TEST_CASE(
    "a square that skips the exact test gets its requested vertices where the mesh has their triangles") {
  const LodScene scene = flat_tile();
  CHECK(vertices_of(refined(scene, kLevels, never)) == Vertices{true, true, true});
  CHECK(vertices_of(refined(scene, kLevels - 1, never)) == Vertices{true, false, false});
  CHECK(vertices_of(refined(scene, kLevels - 1, always)) == Vertices{true, true, true});
}

TEST_CASE("a mesh begins without the requests and skipped tests of the one before") {
  const LodScene scene = flat_tile();
  BisectionForest forest;
  forest.prepare(scene);
  const auto request_all = [&](std::size_t tile, int k, int x, int y) {
    forest.request_centre(tile, k, x, y);
    forest.request_middle(tile, k, x, y, BisectionForest::south);
    forest.request_centre(tile, k - 1, x, y);
    return true;
  };
  forest.begin();
  forest.refine(
      [&](std::size_t tile, int k, int x, int y) {
        forest.skip_exact_test(tile, k, x, y);
        return request_all(tile, k, x, y);
      },
      never);
  CHECK(vertices_of(forest) == Vertices{true, true, false});

  forest.begin();
  forest.refine(request_all, never);
  CHECK(vertices_of(forest) == Vertices{true, false, false});

  forest.begin();
  forest.refine([](std::size_t, int, int, int) { return true; }, always);
  CHECK_FALSE(forest.has(0, 4, 4));
}

}  // namespace cairn::test
