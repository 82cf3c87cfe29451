// Flights over a pack of real terrain: what terrain_test.cpp asks of a made-up pack, with the tiles, blocks
// and depths that a bake makes.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

#include "cairn/build.h"
#include "cairn/terrain.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_selection.h"
#include "runtime/paging/tile_tree.h"
#include "tests/support/flight_pack.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

using test::Faults;
using AreasAndSources = std::map<TileId, TileId>;

constexpr int kMoves = 10000;
constexpr LonLat kHome{-155.5, 19.6};  // Hawaii

// Five cells of Hawaii in a plus shape, up to one tile for the Earth.
std::shared_ptr<const PackReader> bake_hawaii(const std::filesystem::path& data,
                                              const std::filesystem::path& target) {
  BuildOptions options;
  for (const auto& file : std::filesystem::directory_iterator(data / "dted1"))
    options.mosaic.inputs.push_back(file);
  std::sort(options.mosaic.inputs.begin(), options.mosaic.inputs.end());
  options.session.target = target;
  options.grid.tile_size = 257;
  options.grid.top = kMinLevel;
  const auto report = build(options, [](const Progress&) { return true; });
  if (!report) FAIL(report.error().message);
  auto pack = PackReader::open(target);
  REQUIRE(pack.ok());
  return std::make_shared<const PackReader>(std::move(*pack));
}

// Random directions, steps and altitudes around the island; now and then to the other side of the Earth.
class RandomMoves {
 public:
  ViewState next() {
    if (random_() % 1000 == 0) view_.eye = {between(-180, 180), between(-90, 90)};
    if (random_() % 100 == 0) view_.eye = {between(-156.9, -154.1), between(18.1, 20.9)};
    if (random_() % 20 == 0) view_.height_m = std::exp(between(std::log(200.0), std::log(2e6)));
    const double step = view_.height_m / 1e6;
    view_.eye.lon += between(-step, step);
    view_.eye.lat = std::clamp(view_.eye.lat + between(-step, step), -90.0, 90.0);
    view_.heading_deg += between(-20, 20);
    view_.pitch_deg = between(-90, 0);
    return view_;
  }

  static ViewState home() {
    ViewState view;
    view.eye = kHome;
    view.height_m = 5000;
    view.viewport_width_px = 320;
    view.viewport_height_px = 240;
    return view;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::mt19937_64 random_{29};
  ViewState view_ = home();
};

double degrees_covered(const RenderList& list) {
  double degrees = 0;
  for (const RenderTile& tile : list.tiles) {
    const GeoBounds b = tile_bounds(tile.area);
    degrees += (std::min(b.east, 180.0) - b.west) * (std::min(b.north, 90.0) - b.south);
  }
  return degrees;
}

// Against the pack itself, read past the terrain.
void require_true_heights(const RenderList& list, const PackReader& pack, std::size_t which) {
  const RenderTile& tile = list.tiles[which % list.tiles.size()];
  REQUIRE(tile.heights);
  REQUIRE(ancestor_of(tile.area, tile.heights_id.level) == tile.heights_id);
  const auto entry = pack.find(Layer::heights, tile.heights_id);
  REQUIRE(entry.has_value());
  const auto heights = pack.read_height_tile(*entry);
  REQUIRE(heights.ok());
  REQUIRE(heights->samples == tile.heights->samples);
}

const RenderList& rest_at_home(Terrain& terrain, std::size_t& errors) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(300);
  const RenderList* list = &terrain.update(RandomMoves::home(), 1.0 / 60);
  while (!list->is_complete && std::chrono::steady_clock::now() < end) {
    errors += list->errors.size();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    list = &terrain.update(RandomMoves::home(), 1.0 / 60);
  }
  errors += list->errors.size();
  REQUIRE(list->is_complete);
  return *list;
}

struct FlightResult {
  AreasAndSources final_map;
  PagingStats stats;
  std::size_t errors = 0;
};

FlightResult fly(const std::shared_ptr<const PackReader>& pack, int workers, const Faults& faults) {
  TerrainOptions options;
  options.workers = workers;
  options.cache_bytes = std::uint64_t{48} << 20;
  // Hysteresis would let the way home decide what is shown there.
  options.tile_margin = options.level_margin = 0;
  const std::uint64_t before = test::heap_bytes();
  test::reset_peak_heap_bytes();
  auto terrain = Terrain::open(pack, options, test::read_with(pack, faults));
  REQUIRE(terrain.ok());
  FlightResult result;
  rest_at_home(*terrain, result.errors);
  RandomMoves moves;
  for (std::size_t i = 0; i < kMoves; ++i) {
    const RenderList& list = terrain->update(moves.next(), 1.0 / 60);
    result.errors += list.errors.size();
    for (const RenderTile& tile : list.tiles) {
      if (!tile.heights) FAIL("a hole at " << to_string(tile.area) << " after " << i << " moves");
    }
    if (i % 10 == 0 && degrees_covered(list) != 360.0 * 180.0) FAIL("not the whole Earth after " << i);
    if (i % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // let something be loaded
  }
  CHECK(test::peak_heap_bytes() - before <= options.cache_bytes);
  const RenderList& list = rest_at_home(*terrain, result.errors);
  for (std::size_t i = 0; i < list.tiles.size(); ++i) require_true_heights(list, *pack, i);
  for (const RenderTile& tile : list.tiles) result.final_map[tile.area] = tile.heights_id;
  result.stats = terrain->stats();
  CHECK(result.stats.holes == 0);
  return result;
}

// What the list should be, from the index, the selection and the faults alone.
AreasAndSources expected_map(const std::shared_ptr<const PackReader>& pack, const Faults& faults) {
  TileTable table(pack->header().tile_size);
  const TileAvailability contents(pack, &table);
  for (std::size_t i = 0; i < pack->entry_count(); ++i) {
    const TileKey key = key_of(pack->entry(i));
    if (faults.is_damaged(key)) table.set_damaged(key);
  }
  const Occluder occluder(contents.lowest_m());
  const TileTree tree(contents, occluder);
  FocusTile focus(0, 0);
  const SelectionView selection =
      selection_view(RandomMoves::home(), contents, occluder, RefinementPattern::restricted, focus);
  AreasAndSources areas;
  for (const CutNode& node : select_tiles(tree, {&selection, 1}, {}, {}).cut)
    areas[node.area] = node.heights->id;
  return areas;
}

}  // namespace

TEST_CASE(
    "10,000 moves over Hawaii with 1, 2 and 4 workers end in one map, without a hole or a byte too many",
    "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  const auto pack = bake_hawaii(*data, dir.path() / "hawaii.cairn");
  for (const int workers : {1, 2, 4}) {
    const FlightResult result = fly(pack, workers, {});
    CHECK(result.errors == 0);
    const AreasAndSources expected = expected_map(pack, {});
    CHECK(result.final_map == expected);
    // Loading follows the eye: more tiles came than those that are shown in the end.
    std::set<TileId> shown;
    for (const auto& [area, source] : expected) shown.insert(source);
    CHECK(result.stats.tiles_loaded > shown.size());
  }
}

TEST_CASE("10,000 moves over Hawaii on a disk that is slow, fails and is damaged", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  const auto pack = bake_hawaii(*data, dir.path() / "hawaii.cairn");
  for (const int workers : {1, 2, 4}) {
    for (const Faults& faults :
         {Faults{50, 0, 0}, Faults{0, 0.01, 0}, Faults{0, 0, 0.001}, Faults{5, 0.01, 0.05}}) {
      CAPTURE(workers, faults.longest_delay_ms, faults.failing_share, faults.damaged_share);
      const FlightResult result = fly(pack, workers, faults);
      CHECK(result.errors == result.stats.tiles_damaged);
      CHECK(result.final_map == expected_map(pack, faults));
    }
  }
}

}  // namespace cairn
