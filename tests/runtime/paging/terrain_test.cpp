#include "cairn/terrain.h"

#include <chrono>
#include <condition_variable>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

#include "cairn/pack_sampler.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_cut.h"
#include "runtime/paging/tile_selection.h"
#include "runtime/paging/tile_tree.h"
#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

using test::Faults;
using test::FlightPack;

TerrainOptions small_options(int workers = 2, std::uint64_t cache_mib = 96) {
  TerrainOptions options;
  options.workers = workers;
  options.cache_bytes = cache_mib << 20;
  options.tile_margin = options.level_margin = 0;
  return options;
}

/// An eye that goes anywhere: short steps, long ones, up and down, over the pack's detail and far from it.
class RandomFlight {
 public:
  explicit RandomFlight(std::uint64_t seed) : random_(seed) {
    view_.eye = FlightPack::kMiddle;
    view_.height_m = 3000;
    view_.viewport_width_px = 320;
    view_.viewport_height_px = 240;
  }

  const ViewState& next() {
    if (random_() % 500 == 0) view_.eye = {between(-180, 180), between(-90, 90)};
    if (random_() % 100 == 0) view_.eye = {between(27, 30), between(36, 38)};
    if (random_() % 20 == 0) view_.height_m = std::exp(between(std::log(100.0), std::log(3e6)));
    const double step = view_.height_m / 1e6;
    view_.eye.lon += between(-step, step);
    view_.eye.lat = std::clamp(view_.eye.lat + between(-step, step), -90.0, 90.0);
    view_.heading_deg += between(-20, 20);
    view_.pitch_deg = between(-90, 0);
    return view_;
  }

  ViewState home() const {
    ViewState home = view_;
    home.eye = {28.3, 36.7};
    home.height_m = 3000;
    home.heading_deg = home.pitch_deg = 0;
    return home;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::mt19937_64 random_;
  ViewState view_;
};

/// Whether `a` comes before `b` in a walk of the tree that takes children in the order of their quadrants.
bool is_depth_first(const TileId& a, const TileId& b) {
  for (int level = kMinLevel + 1; level <= std::min(a.level, b.level); ++level) {
    const int of_a = quadrant_of(ancestor_of(a, level)), of_b = quadrant_of(ancestor_of(b, level));
    if (of_a != of_b) return of_a < of_b;
  }
  return false;
}

/// The areas cover the Earth, each place once.
void require_cover(const RenderList& list) {
  double degrees = 0;
  for (std::size_t i = 0; i < list.tiles.size(); ++i) {
    const TileId& area = list.tiles[i].area;
    const GeoBounds b = tile_bounds(area);
    degrees += (std::min(b.east, 180.0) - b.west) * (std::min(b.north, 90.0) - b.south);
    if (i == 0) continue;
    const TileId& before = list.tiles[i - 1].area;
    const int level = std::min(area.level, before.level);
    REQUIRE(ancestor_of(area, level) != ancestor_of(before, level));
    REQUIRE(is_depth_first(before, area));
  }
  REQUIRE(degrees == 360.0 * 180.0);
}

void require_right_data(const RenderList& list) {
  for (const RenderTile& tile : list.tiles) {
    REQUIRE(tile.heights);
    REQUIRE(ancestor_of(tile.area, tile.heights_id.level) == tile.heights_id);
    REQUIRE(tile.heights->samples[0] == FlightPack::first_sample(tile.heights_id));
  }
}

/// Updates with the eye at rest until the map is complete.
const RenderList& rest(Terrain& terrain, const ViewState& view, std::size_t* errors = nullptr) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  const RenderList* list = nullptr;
  do {
    if (list != nullptr) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    list = &terrain.update(view, 1.0 / 60);
    if (errors != nullptr) *errors += list->errors.size();
  } while (!list->is_complete && std::chrono::steady_clock::now() < end);
  REQUIRE(list->is_complete);
  return *list;
}

using AreasAndSources = std::map<TileId, TileId>;

AreasAndSources areas_of(const RenderList& list) {
  AreasAndSources areas;
  for (const RenderTile& tile : list.tiles) areas[tile.area] = tile.heights_id;
  return areas;
}

Terrain open(const FlightPack& pack, const TerrainOptions& options, const Faults& faults = {}) {
  auto reader = pack.open();
  Result<Terrain> terrain = Terrain::open(reader, options, test::read_with(reader, faults));
  if (!terrain) FAIL(terrain.error().message);
  return std::move(*terrain);
}

struct FlightResult {
  AreasAndSources final_map;
  PagingStats stats;
  std::size_t errors = 0;
};

/// Flies, checks every frame, and rests at home in the end.
FlightResult fly(const FlightPack& pack, const TerrainOptions& options, const Faults& faults, int moves) {
  const std::uint64_t before = test::heap_bytes();
  test::reset_peak_heap_bytes();
  Terrain terrain = open(pack, options, faults);
  RandomFlight flight(17);
  FlightResult result;
  rest(terrain, flight.home(), &result.errors);
  for (int i = 0; i < moves; ++i) {
    const RenderList& list = terrain.update(flight.next(), 1.0 / 60);
    result.errors += list.errors.size();
    if (i % 10 == 0) require_cover(list);
    for (const RenderTile& tile : list.tiles) {
      if (!tile.heights) FAIL("a hole at " << to_string(tile.area));
    }
    if (i % 50 == 0) require_right_data(list);
  }
  const RenderList& list = rest(terrain, flight.home(), &result.errors);
  require_cover(list);
  require_right_data(list);
  result.final_map = areas_of(list);
  result.stats = terrain.stats();
  CHECK(test::peak_heap_bytes() - before <= options.cache_bytes);
  return result;
}

/// What the list should be, from the selection and the faults alone.
AreasAndSources expected_map(const FlightPack& pack, const ViewState& view, const Faults& faults,
                             RefinementPattern pattern = RefinementPattern::restricted) {
  const auto reader = pack.open();
  TileTable table(reader->header().tile_size);
  const TileAvailability contents(reader, &table);
  for (std::size_t i = 0; i < contents.pack().entry_count(); ++i) {
    const TileKey key = key_of(contents.pack().entry(i));
    if (faults.is_damaged(key)) table.set_damaged(key);
  }
  const Occluder occluder(contents.lowest_m());
  const TileTree tree(contents, occluder);
  FocusTile focus(0, 0);
  const SelectionView selection = selection_view(view, contents, occluder, pattern, focus);
  AreasAndSources areas;
  for (const CutNode& node : select_tiles(tree, {&selection, 1}, {}, {}).cut) {
    areas[node.area] = node.heights->id;
  }
  return areas;
}

constexpr int kMoves = 10000;

}  // namespace

TEST_CASE("a terrain at rest shows the tiles that are selected for its view, whatever the pattern") {
  const FlightPack pack;
  for (const RefinementPattern pattern :
       {RefinementPattern::normal, RefinementPattern::plus, RefinementPattern::cross,
        RefinementPattern::restricted, RefinementPattern::balanced}) {
    TerrainOptions options = small_options(2, 128);
    options.pattern = pattern;
    Terrain terrain = open(pack, options);
    RandomFlight flight(1);
    const RenderList& list = rest(terrain, flight.home());
    require_cover(list);
    require_right_data(list);
    CHECK(terrain.eye_tile() == tile_at({28.3, 36.7}, FlightPack::kFinest));
    CHECK(areas_of(list) == expected_map(pack, flight.home(), {}, pattern));
    CHECK(list.error_px <= 0.5);
    CHECK_FALSE(list.is_limited);
  }
}

TEST_CASE("10,000 moves with 1, 2 and 4 workers: no hole, never over the budget, the same map in the end",
          "[slow]") {
  const FlightPack pack;
  std::set<AreasAndSources> maps;
  for (const int workers : {1, 2, 4}) {
    const FlightResult result = fly(pack, small_options(workers), {}, kMoves);
    CHECK(result.stats.holes == 0);
    CHECK(result.errors == 0);
    maps.insert(result.final_map);
  }
  CHECK(maps.size() == 1);
  CHECK(*maps.begin() == expected_map(pack, RandomFlight(17).home(), {}));
}

TEST_CASE("10,000 moves over a slow disk", "[slow]") {
  const FlightPack pack;
  Faults faults;
  faults.longest_delay_ms = 50;
  const FlightResult result = fly(pack, small_options(2), faults, kMoves);
  CHECK(result.stats.holes == 0);
  CHECK(result.stats.updates_behind > 0);
  CHECK(result.final_map == expected_map(pack, RandomFlight(17).home(), {}));
}

TEST_CASE("10,000 moves over a disk that fails one read in a hundred", "[slow]") {
  const FlightPack pack;
  Faults faults;
  faults.failing_share = 0.01;
  const FlightResult result = fly(pack, small_options(2), faults, kMoves);
  CHECK(result.stats.holes == 0);
  CHECK(result.stats.reads_failed > 0);
  CHECK(result.errors == 0);  // each was read at a second try
  CHECK(result.final_map == expected_map(pack, RandomFlight(17).home(), {}));
}

TEST_CASE("10,000 moves over a pack with damaged tiles: each is reported once and an ancestor drawn",
          "[slow]") {
  const FlightPack pack;
  for (const double share : {0.001, 0.05}) {
    Faults faults;
    faults.damaged_share = share;
    const FlightResult result = fly(pack, small_options(2), faults, kMoves);
    CHECK(result.stats.holes == 0);
    CHECK(result.errors == result.stats.tiles_damaged);
    CHECK(result.stats.reads_failed == result.stats.tiles_damaged);  // and never read again
    CHECK(result.final_map == expected_map(pack, RandomFlight(17).home(), faults));
  }
}

TEST_CASE("everything at once, with the least memory that works") {
  const FlightPack pack;
  Faults faults{3, 0.05, 0.02};
  TerrainOptions options = small_options(4);
  options.cache_bytes = 24u << 20;
  const FlightResult tight = fly(pack, options, faults, kMoves / 5);
  CHECK(tight.stats.holes == 0);
  for (const auto& [area, source] : tight.final_map) CHECK(area.level <= FlightPack::kFinest);
}

TEST_CASE("a budget too small for the view draws what it holds, and says how good that is") {
  const FlightPack pack;
  double error_px = std::numeric_limits<double>::infinity();
  std::size_t tiles = 0;
  for (const std::uint64_t mib : {16, 20, 24, 32, 96}) {
    Terrain terrain = open(pack, small_options(1, mib));
    const RenderList& list = rest(terrain, RandomFlight(1).home());
    require_cover(list);
    require_right_data(list);
    CHECK(list.is_limited == (list.error_px > 0.5));
    CHECK(list.error_px <= error_px);
    CHECK(list.tiles.size() >= tiles);
    error_px = list.error_px;
    tiles = list.tiles.size();
  }
  CHECK(error_px <= 0.5);
}

TEST_CASE("an option out of range is refused, and a budget too small with the least that works") {
  const FlightPack pack;
  const auto reader = pack.open();
  const auto refused = [&](auto change) {
    TerrainOptions options;
    change(options);
    const Result<Terrain> terrain = Terrain::open(reader, options);
    return !terrain && terrain.error().code == ErrorCode::usage;
  };
  CHECK(refused([](TerrainOptions& o) { o.workers = 0; }));
  CHECK(refused([](TerrainOptions& o) { o.pattern = RefinementPattern::nine; }));
  CHECK(refused([](TerrainOptions& o) { o.tile_margin = 1; }));
  CHECK(refused([](TerrainOptions& o) { o.level_margin = -0.1; }));
  CHECK(refused([](TerrainOptions& o) { o.look_ahead_s = NAN; }));
  CHECK(refused([](TerrainOptions& o) { o.tolerance_px = 0; }));
  CHECK(refused([](TerrainOptions& o) { o.tolerance_px = NAN; }));
  CHECK(refused([](TerrainOptions& o) { o.texel_px = -1; }));
  CHECK(refused([](TerrainOptions& o) { o.cache_bytes = 1 << 20; }));
  CHECK_FALSE(refused([](TerrainOptions&) {}));
}

TEST_CASE("an eye at rest is still, and one that turns and comes back loads nothing again") {
  const FlightPack pack;
  Terrain terrain = open(pack, small_options(2, 512));
  const ViewState home = RandomFlight(1).home();
  const AreasAndSources at_home = areas_of(rest(terrain, home));
  PagingStats before = terrain.stats();
  for (int i = 0; i < 100; ++i) CHECK(terrain.update(home, 0.01).is_complete);
  CHECK(terrain.stats().moves == before.moves);
  const auto turn = [&] {
    ViewState view = home;
    for (int i = 0; i <= 12; ++i) {
      view.heading_deg = 30.0 * i;
      rest(terrain, view);
    }
  };
  turn();
  CHECK(areas_of(rest(terrain, home)) == at_home);
  before = terrain.stats();
  turn();
  CHECK(terrain.stats().tiles_loaded == before.tiles_loaded);
}

TEST_CASE("requests that nobody has begun are withdrawn when the eye goes elsewhere") {
  const FlightPack pack;
  const auto reader = pack.open();
  std::mutex mutex;
  std::condition_variable opened;
  bool gate_open = false;
  std::vector<TileId> reads;
  const ReadTile gated = [&, read = read_from(reader)](const IndexEntry& entry) {
    std::unique_lock lock(mutex);
    reads.push_back(entry.id);
    opened.wait(lock, [&] { return gate_open || entry.id.level <= -5; });
    lock.unlock();
    return read(entry);
  };
  constexpr int kWorkers = 2;
  Result<Terrain> terrain = Terrain::open(reader, small_options(kWorkers), gated);
  REQUIRE(terrain.ok());
  RandomFlight flight(1);
  ViewState here = flight.home();
  const auto reads_begun = [&] {
    const std::lock_guard lock(mutex);
    return std::count_if(reads.begin(), reads.end(), [](const TileId& id) { return id.level > -5; });
  };
  while (reads_begun() < kWorkers) terrain->update(here, 0.01);
  for (int i = 0; i < 20; ++i) terrain->update(here, 0.01);  // never waits, though the disk hangs

  ViewState there = here;
  there.eye = {-100, -30};
  for (int i = 0; i < 20; ++i) terrain->update(there, 0.01);
  CHECK(terrain->stats().tiles_withdrawn > 0);
  {
    const std::lock_guard lock(mutex);
    gate_open = true;
  }
  opened.notify_all();
  rest(*terrain, there);
  CHECK(terrain->stats().tiles_stale <= kWorkers);
  std::set<TileId> once(reads.begin(), reads.end());
  CHECK(once.size() == reads.size());
}

TEST_CASE("a root that cannot be read is drawn flat and reported once") {
  const FlightPack pack;
  const auto reader = pack.open();
  const ReadTile broken = [read = read_from(reader)](const IndexEntry& entry) -> Result<LoadedTile> {
    if (entry.id.level == kMinLevel) return bad_data("root: damaged");
    return read(entry);
  };
  Result<Terrain> terrain = Terrain::open(reader, small_options(), broken);
  REQUIRE(terrain.ok());
  ViewState far;
  far.height_m = 1e9;
  const RenderList& list = rest(*terrain, far);
  REQUIRE(list.tiles.size() == 1);
  REQUIRE(list.tiles[0].heights);
  CHECK(list.tiles[0].heights->samples[5] == FlightPack::first_sample({kMinLevel, 0, 0}) + 48);
  CHECK(terrain->stats().tiles_damaged == 1);
}

TEST_CASE("blocks damaged in the file survive: reported with their place, ancestors drawn") {
  const FlightPack pack;
  const TileId eye = tile_at({28.3, 36.7}, FlightPack::kFinest);
  const auto good = pack.open();
  // Tiles share their blocks, so that one flipped bit damages a sixteenth of them; the root must not be one.
  TileId victim = eye;
  const auto offset = [&](const TileId& id) { return good->find_nearest(Layer::heights, id)->offset; };
  while (offset(victim) == offset({kMinLevel, 0, 0})) victim = neighbour_of(victim, 1, 0);
  {
    std::fstream file(pack.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(offset(victim)) + 40);
    file.put('\x5a');
  }
  const auto reader = pack.open();
  Result<Terrain> terrain = Terrain::open(reader, small_options());
  REQUIRE(terrain.ok());
  RandomFlight flight(1);
  std::set<std::string> messages;
  std::size_t errors = 0;
  const RenderList* list = &terrain->update(flight.home(), 0.01);
  while (!list->is_complete) {
    list = &terrain->update(flight.home(), 0.01);
    errors += list->errors.size();
    for (const Error& error : list->errors) messages.insert(error.message);
  }
  CHECK(errors > 0);
  CHECK(messages.size() == errors);
  CHECK(messages.begin()->find("test.cairn: heights tile ") != std::string::npos);
  require_cover(*list);
  for (const RenderTile& tile : list->tiles) {
    REQUIRE(tile.heights);
    REQUIRE(tile.heights->samples[0] == FlightPack::first_sample(tile.heights_id));
    REQUIRE(reader->find(Layer::heights, tile.heights_id)->offset != offset(victim));
  }
}

TEST_CASE("the ground's height is that of the pack's finest tile at the place") {
  const FlightPack pack;
  const auto reader = pack.open();
  Result<Terrain> terrain = Terrain::open(reader, small_options());
  REQUIRE(terrain.ok());
  RandomFlight flight(1);
  CHECK_FALSE(terrain->ground_height_m({28.3, 36.7}).has_value());
  const RenderList& list = rest(*terrain, flight.home());
  PackSampler sampler(*reader);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90), near(-0.05, 0.05);
  for (int i = 0; i < 1000; ++i) {
    const LonLat place =
        i % 2 == 0 ? LonLat{28.3 + near(random), 36.7 + near(random)} : LonLat{lon(random), lat(random)};
    const auto tile = std::find_if(list.tiles.begin(), list.tiles.end(), [&](const RenderTile& t) {
      return tile_at(place, t.area.level) == t.area;
    });
    REQUIRE(tile != list.tiles.end());
    const auto expected = sampler.height_at(place, tile->heights_id.level);
    REQUIRE(expected.ok());
    REQUIRE(expected->has_value());
    const auto height = terrain->ground_height_m({place.lon + 360 * (i % 3 - 1), place.lat});
    REQUIRE(height.has_value());
    REQUIRE(*height == Approx((**expected).metres).margin(1e-6));
  }
}

TEST_CASE("a cold start shows coarse before fine") {
  const FlightPack pack;
  Terrain terrain = open(pack, small_options(1));
  RandomFlight flight(1);
  std::vector<int> finest;
  const RenderList* list = &terrain.update(flight.home(), 0.01);
  while (!list->is_complete) {
    int level = kMinLevel;
    for (const RenderTile& tile : list->tiles) level = std::max(level, tile.area.level);
    if (finest.empty() || finest.back() != level) finest.push_back(level);
    list = &terrain.update(flight.home(), 0.01);
  }
  CHECK(std::is_sorted(finest.begin(), finest.end()));
  CHECK(finest.size() > 3);
}

TEST_CASE("a pack whose coarsest level is 0 is shown whole, from afar and from within") {
  const FlightPack pack(0);
  const auto reader = pack.open();
  Terrain terrain = open(pack, small_options());
  ViewState view = RandomFlight(1).home();
  const auto require_shown = [&](const RenderList& list) {
    require_cover(list);
    for (const RenderTile& tile : list.tiles) {
      const GeoBounds b = tile_bounds(tile.area);
      const bool outside = b.east <= 27 || b.west >= 30 || b.north <= 36 || b.south >= 38;
      INFO(to_string(tile.area));
      REQUIRE(static_cast<bool>(tile.heights) == !outside);
    }
  };
  require_shown(rest(terrain, view));
  view.height_m = 5e6;
  require_shown(rest(terrain, view));
  view.eye = {-120, -40};
  require_shown(rest(terrain, view));
  CHECK(terrain.stats().holes == 0);
}

TEST_CASE("imagery deeper than the heights is shown over windows of the heights") {
  const test::TempDir dir;
  const LonLat place{10.3, 45.3};
  test::write_imagery_pack(dir.path() / "imagery.cairn", place, 0, 3);
  auto opened = PackReader::open(dir.path() / "imagery.cairn");
  REQUIRE(opened.ok());
  const auto reader = std::make_shared<const PackReader>(std::move(*opened));
  Result<Terrain> terrain = Terrain::open(reader, small_options(2, 256));
  REQUIRE(terrain.ok());
  ViewState view;
  view.eye = place;
  view.height_m = 500;
  const RenderList& list = rest(*terrain, view);
  require_cover(list);
  int windows = 0;
  for (const RenderTile& tile : list.tiles) {
    REQUIRE(tile.heights);
    REQUIRE(tile.imagery);
    REQUIRE(tile.imagery->texels.size() == texture_chain_bytes(tile.imagery->format, 256));
    REQUIRE(ancestor_of(tile.area, tile.heights_id.level) == tile.heights_id);
    REQUIRE(ancestor_of(tile.area, tile.imagery_id.level) == tile.imagery_id);
    windows += tile.area.level == 3 && tile.imagery_id == tile.area && tile.heights_id.level == 0;
  }
  CHECK(terrain->eye_tile() == tile_at(place, 3));
  CHECK(windows == 4);  // the four children of the one level-2 tile that has any
}

TEST_CASE("a tile of one colour becomes a texture of that colour") {
  const test::TempDir dir;
  test::write_imagery_pack(dir.path() / "imagery.cairn", {10.3, 45.3}, 0, 0);
  auto opened = PackReader::open(dir.path() / "imagery.cairn");
  REQUIRE(opened.ok());
  const auto reader = std::make_shared<const PackReader>(std::move(*opened));
  IndexEntry entry = *reader->find(Layer::imagery, {kMinLevel, 0, 0});
  entry.flags = kConstant;
  entry.min_quanta = static_cast<std::int32_t>(0x80FF00FFu);  // R 255, G 0, B 255, A 128
  const auto tile = read_from(reader)(entry);
  REQUIRE(tile.ok());
  REQUIRE(tile->texture->format == TextureFormat::bc3);
  const auto byte = [&](std::size_t i) { return std::to_integer<int>(tile->texture->texels[i]); };
  for (const std::size_t block : {std::size_t{0}, tile->texture->texels.size() - 16}) {
    CHECK(byte(block) == 128);
    CHECK(byte(block + 8) == 0x1F);  // red and blue in full, no green, in 5-6-5
    CHECK(byte(block + 9) == 0xF8);
  }
}

TEST_CASE("what lies ahead is loaded before the eye gets there", "[slow]") {
  const FlightPack pack;
  const auto behind = [&](double look_ahead_s) {
    TerrainOptions options = small_options(2, 96);
    options.look_ahead_s = look_ahead_s;
    Terrain terrain = open(pack, options);
    RandomFlight flight(1);
    ViewState view = flight.home();
    rest(terrain, view);
    std::uint64_t frames = 0;
    for (int i = 0; i < 600; ++i) {
      view.eye.lon += tile_width_degrees(FlightPack::kFinest) / 100;  // a tile every 100 frames
      frames += !terrain.update(view, 1.0 / 60).is_complete;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return frames;
  };
  CHECK(behind(2) < behind(0));
}

}  // namespace cairn
