// Objects are paged with the tiles: all that a view can see, models once each, within the budget.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <thread>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/surface.h"
#include "cairn/terrain.h"
#include "tests/support/object_pack.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr LonLat kTown{10.4, 45.4};
constexpr int kFinestHeights = 3;

/// Boxes of 3 to 80 m around a place, on hills, in a pack whose coarsest tile is that of a degree.
class TownPack {
 public:
  explicit TownPack(std::size_t count, LonLat middle = kTown, double spread_degrees = 0.2) {
    std::mt19937 random(5);
    std::vector<ObjectModel> models;
    for (std::uint16_t i = 0; i < 12; ++i) {
      const auto size = static_cast<float>(3 * std::pow(1.35, i));
      models.push_back(box_model("box " + std::to_string(i), size / 2, size,
                                 {static_cast<std::uint8_t>(20 * i), 90, 200}, 3));
      sizes_m.push_back(models.back().size_m());
    }
    std::normal_distribution<double> spread(0, spread_degrees / 2);
    for (std::size_t i = 0; i < count; ++i) {
      TestObject object;
      object.place = {middle.lon + spread(random), middle.lat + spread(random)};
      if (object.place.lon >= 180) object.place.lon -= 360;
      if (object.place.lon < -180) object.place.lon += 360;
      object.place.lat = std::clamp(object.place.lat, -89.9999, 89.9999);
      object.placed.model = static_cast<std::uint16_t>(random() % models.size());
      object.placed.heading = static_cast<std::uint16_t>(random());
      object.placed.scale = static_cast<std::uint16_t>(2048 + random() % 4096);
      objects.push_back(object);
    }
    std::vector<TileId> tiles;
    for (const TestObject& object : objects) tiles.push_back(tile_at(object.place, kFinestHeights));
    write_object_pack(dir_.path() / "town.cairn", {257, kFinestHeights, hills, {}}, with_ancestors(tiles, -4),
                      models, objects);
  }

  std::shared_ptr<const PackReader> open() const {
    Result<PackReader> pack = PackReader::open(dir_.path() / "town.cairn");
    REQUIRE(pack.ok());
    return std::make_shared<const PackReader>(std::move(*pack));
  }
  double size_m(const TestObject& object) const {
    return static_cast<double>(sizes_m[object.placed.model]) * object.placed.scale_factor();
  }

  std::vector<TestObject> objects;
  std::vector<float> sizes_m;

 private:
  TempDir dir_;
};

const RenderList& settle(Terrain& terrain, const ViewState& view) {
  const RenderList* list = &terrain.update(view, 1.0 / 60);
  for (int i = 0; !list->is_settled && i < 20000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    list = &terrain.update(view, 1.0 / 60);
  }
  return *list;
}

ViewState view_near(LonLat eye, double height_m, double heading_deg, double pitch_deg) {
  ViewState view;
  view.eye = eye;
  view.height_m = height_m;
  view.heading_deg = heading_deg;
  view.pitch_deg = pitch_deg;
  return view;
}

/// By model and heading, which no two objects of a pack share often.
using Names = std::multimap<std::pair<std::uint16_t, std::uint16_t>, const StandingObject*>;
Names listed(const RenderList& list) {
  Names names;
  for (const auto& tile : list.objects) {
    for (const StandingObject& object : tile->all())
      names.emplace(std::pair(object.placed.model, object.placed.heading), &object);
  }
  return names;
}

}  // namespace

TEST_CASE("once settled, no object is missing that a view sees larger than asked for") {
  for (const LonLat middle : {kTown, LonLat{179.97, -12.3}, LonLat{31, 89.95}}) {
    const TownPack town(3000, middle);
    const auto pack = town.open();
    Result<Terrain> terrain = Terrain::open(pack);
    REQUIRE(terrain.ok());
    std::mt19937 random(2);
    const auto share = [&] { return static_cast<double>(random() % 1000) / 1000; };
    std::size_t needed = 0, missing = 0, needless = 0, all = 0;
    for (int i = 0; i < 40; ++i) {
      const ViewState view = view_near(
          {middle.lon + 0.3 * (share() - 0.5), std::clamp(middle.lat + 0.3 * (share() - 0.5), -90.0, 90.0)},
          1600 * std::pow(10, share()), 360 * share(), -60 * share());
      const RenderList& list = settle(*terrain, view);
      REQUIRE(list.is_complete);
      const Names names = listed(list);
      all += names.size();
      const CameraFrame camera = camera_frame(view);
      const auto inward = inward_normals(camera, view);
      for (const TestObject& object : town.objects) {
        const double height_m = terrain->ground_height_m(object.place).value_or(0);
        const glm::dvec3 to = to_geocentric(object.place, height_m) - camera.position;
        const double size_m = town.size_m(object);
        const bool is_inside = std::all_of(
            inward.begin(), inward.end(), [&](const glm::dvec3& normal) { return glm::dot(to, normal) > 0; });
        const bool is_seen = is_inside && size_m / glm::length(to) / pixel_footprint_m(view, 1) > 2;
        const bool is_listed = names.contains({object.placed.model, object.placed.heading});
        needed += is_seen;
        missing += is_seen && !is_listed;
        needless += !is_seen && is_listed;
      }
    }
    CAPTURE(middle.lon, needed, needless, all);
    CHECK(needed > 500);
    CHECK(missing == 0);
  }
}

TEST_CASE("each model is in memory once, while a tile needs it") {
  const TownPack town(500);
  const auto pack = town.open();
  Result<Terrain> terrain = Terrain::open(pack);
  REQUIRE(terrain.ok());
  const ViewState near = view_near(kTown, 1500, 0, -30);
  settle(*terrain, near);
  const PagingStats stats = terrain->stats();
  CHECK(stats.models_resident == 12);
  CHECK(stats.models_loaded == 12);
  CHECK(stats.model_bytes > 12 * 64 * 64);
  CHECK(stats.objects_resident > 100);
  // Objects of a list that is kept keep their models.
  const std::vector<std::shared_ptr<const LoadedObjects>> kept = settle(*terrain, near).objects;
  REQUIRE(!kept.empty());
  Result<Terrain> other = Terrain::open(pack);
  REQUIRE(other.ok());
  settle(*other, near);
  CHECK(other->stats().models_loaded == 12);
  other = Terrain::open(pack);
  REQUIRE(other.ok());
  CHECK(other->stats().models_resident == 0);
  CHECK(kept[0]->models()[0]->levels.size() == 2);
}

TEST_CASE(
    "models are freed when the last tile that needs them is evicted, and none is read twice on the way") {
  const TownPack town(20000, kTown, 0.6);
  const auto pack = town.open();
  TerrainOptions options;
  options.workers = 1;
  options.cache_bytes = 40u << 20;
  Result<Terrain> terrain = Terrain::open(pack, options);
  if (!terrain) FAIL(terrain.error().message);
  std::uint64_t most = 0;
  for (int i = 0; i < 60; ++i) {
    settle(*terrain, view_near({kTown.lon - 0.6 + 0.02 * i, kTown.lat}, 1500, 90, -20));
    const PagingStats stats = terrain->stats();
    most = std::max(most, stats.resident_bytes + stats.model_bytes);
    CHECK(stats.models_resident <= 12);
  }
  CHECK(terrain->stats().models_loaded == 12);
  CHECK(most <= options.cache_bytes);
}

TEST_CASE("a model or a tile of objects that is damaged is one error, and the rest is drawn") {
  const TownPack town(400);
  const auto pack = town.open();
  const ReadTile read = read_from(pack);
  TileId broken;
  Result<Terrain> terrain = Terrain::open(pack, {}, [&](const IndexEntry& entry) -> Result<LoadedTile> {
    if (entry.layer != Layer::objects || broken != TileId{} || entry.min_quanta < 5) return read(entry);
    broken = entry.id;
    return bad_data("objects tile: expected one, found none");
  });
  REQUIRE(terrain.ok());
  std::size_t errors = 0;
  const ViewState view = view_near(kTown, 2000, 0, -60);
  for (int i = 0; i < 3000; ++i) {
    const RenderList& list = terrain->update(view, 1.0 / 60);
    errors += list.errors.size();
    if (list.is_settled) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const RenderList& list = settle(*terrain, view);
  CHECK(errors == 1);
  CHECK(list.is_settled);
  CHECK(!list.is_complete);
  CHECK(!list.objects.empty());
  for (const auto& tile : list.objects) CHECK(tile->tile() != broken);
}

TEST_CASE("no objects are loaded where none are asked for") {
  const TownPack town(300);
  const auto pack = town.open();
  TerrainOptions options;
  options.object_px = std::numeric_limits<double>::infinity();
  Result<Terrain> terrain = Terrain::open(pack, options);
  REQUIRE(terrain.ok());
  CHECK(settle(*terrain, view_near(kTown, 1500, 0, -30)).objects.empty());
  CHECK(terrain->stats().models_loaded == 0);
}

}  // namespace cairn::test
