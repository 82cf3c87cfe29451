// What a Terrain does with tile sources that fail, lie, throw, wait or are cancelled, and with impossible
// views.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "cairn/terrain.h"
#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

using test::FlightPack;

TerrainOptions options_of(std::uint64_t cache_mib = 48) {
  TerrainOptions options;
  options.cache_bytes = cache_mib << 20;
  options.look_ahead_s = 0;
  // What was shown before decides nothing, so that every way to a place gives equal lists.
  options.tile_margin = options.level_margin = 0;
  return options;
}

ViewState home() {
  ViewState view;
  view.eye = {28.3, 36.7};
  view.height_m = 3000;
  view.viewport_width_px = 320;
  view.viewport_height_px = 240;
  return view;
}

/// Updates with the eye at rest until nothing changes any more; the messages of all errors on the way.
const RenderList& settle(Terrain& terrain, const ViewState& view, std::vector<std::string>& messages) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  const RenderList* list = nullptr;
  do {
    if (list != nullptr) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    list = &terrain.update(view, 1.0 / 60);
    for (const Error& error : list->errors) messages.push_back(error.message);
  } while (!list->is_settled && std::chrono::steady_clock::now() < end);
  REQUIRE(list->is_settled);
  return *list;
}

const RenderList& settle(Terrain& terrain, const ViewState& view) {
  std::vector<std::string> messages;
  const RenderList& list = settle(terrain, view, messages);
  CHECK(messages.empty());
  return list;
}

using Sources = std::map<TileId, TileId>;

Sources sources_of(const RenderList& list) {
  Sources sources;
  for (const RenderTile& tile : list.tiles) sources[tile.area] = tile.heights_id;
  return sources;
}

Sources sources_at_home(const std::shared_ptr<const PackReader>& reader) {
  auto terrain = Terrain::open(reader, options_of());
  REQUIRE(terrain.ok());
  return sources_of(settle(*terrain, home()));
}

/// Reads that wait in a queue until they are answered, by whichever thread asks.
class PendingReads {
 public:
  RequestTile source(ReadTile read) {
    read_ = std::move(read);
    return [this](const IndexEntry& entry, std::stop_token stop, TileDone done) {
      const std::lock_guard lock(mutex_);
      pending_.push_back({entry, std::move(stop), std::move(done)});
    };
  }

  struct Pending {
    IndexEntry entry;
    std::stop_token stop;
    TileDone done;
  };
  std::vector<Pending> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(pending_, {});
  }

  /// Answers all that waits; stopped reads with an error.
  std::size_t answer() {
    std::size_t stopped = 0;
    for (Pending& each : take()) {
      stopped += each.stop.stop_requested();
      each.done(each.stop.stop_requested() ? Result<LoadedTile>(failed("stopped")) : read_(each.entry));
    }
    return stopped;
  }

 private:
  ReadTile read_;
  std::mutex mutex_;
  std::vector<Pending> pending_;
};

}  // namespace

TEST_CASE("a read that throws is an error of its tile, repeated, and reported once") {
  const FlightPack pack;
  const auto reader = pack.open();
  const TileId victim = tile_at({28.3, 36.7}, 3);
  std::atomic<int> calls = 0;
  const auto throwing = [&, read = read_from(reader)](const IndexEntry& entry) -> Result<LoadedTile> {
    if (entry.id != victim) return read(entry);
    if (++calls % 2 == 0) throw 7;
    throw std::runtime_error("time is up");
  };
  auto terrain = Terrain::open(reader, options_of(), throwing);
  REQUIRE(terrain.ok());
  std::vector<std::string> messages;
  const RenderList& list = settle(*terrain, home(), messages);
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].find("heights tile " + to_string(victim)) == 0);
  CHECK(messages[0].find("an exception: time is up") != std::string::npos);
  CHECK(calls >= 5);
  CHECK_FALSE(list.is_complete);
  for (const RenderTile& tile : list.tiles) {
    REQUIRE(tile.heights);
    CHECK(tile.heights_id != victim);
  }
}

TEST_CASE("a tile that is not what its entry says is an error, and its ancestor is drawn") {
  const FlightPack pack;
  const auto reader = pack.open();
  const TileId victim = tile_at({28.3, 36.7}, 3);
  const int size = reader->header().tile_size;
  const auto side = static_cast<std::size_t>(size);
  const auto tile_of = [](int tile_size, std::size_t samples, std::size_t voids) {
    return LoadedTile{std::make_shared<const HeightTile>(HeightTile{
                          tile_size, std::vector<std::int32_t>(samples), std::vector<std::uint8_t>(voids)}),
                      nullptr};
  };
  for (const LoadedTile& wrong :
       {LoadedTile{}, tile_of(17, 17 * 17, 0), tile_of(size, 0, 0), tile_of(size, side * side - 1, 0),
        tile_of(size, side * side, 5), tile_of(size + 1, side * side, 0)}) {
    const auto lying = [&, read = read_from(reader)](const IndexEntry& entry) -> Result<LoadedTile> {
      return entry.id == victim ? Result<LoadedTile>(wrong) : read(entry);
    };
    auto terrain = Terrain::open(reader, options_of(), lying);
    REQUIRE(terrain.ok());
    std::vector<std::string> messages;
    const RenderList& list = settle(*terrain, home(), messages);
    REQUIRE(messages.size() == 1);
    CHECK(messages[0].find("heights tile " + to_string(victim) + ": expected ") == 0);
    CHECK(list.is_complete);
    CHECK(terrain->stats().tiles_damaged == 1);
    for (const RenderTile& tile : list.tiles) CHECK(tile.heights_id != victim);
    CHECK(terrain->ground_height_m(home().eye).has_value());
  }
}

TEST_CASE("a texture is checked likewise") {
  IndexEntry entry;
  entry.layer = Layer::imagery;
  const auto check = [&](TextureFormat format, int size, std::size_t bytes) {
    return check_tile(entry,
                      {nullptr, std::make_shared<const TextureTile>(
                                    TextureTile{format, size, std::vector<std::byte>(bytes)})},
                      257)
        .ok();
  };
  const std::size_t bytes = texture_chain_bytes(TextureFormat::bc1, 256);
  CHECK(check(TextureFormat::bc1, 256, bytes));
  CHECK_FALSE(check(TextureFormat::bc3, 256, bytes));
  CHECK_FALSE(check(TextureFormat::bc1, 256, bytes - 1));
  CHECK_FALSE(check(TextureFormat::bc1, 128, bytes));
  CHECK_FALSE(check(static_cast<TextureFormat>(2), 256, bytes));
  CHECK_FALSE(check_tile(entry, LoadedTile{}, 257).ok());
}

TEST_CASE("after an outage all is read that could not be, from the start and on the way") {
  const FlightPack pack;
  const auto reader = pack.open();
  const Sources expected = sources_at_home(reader);
  for (const bool fails_from_the_start : {true, false}) {
    std::atomic<bool> is_up = !fails_from_the_start;
    const auto failing = [&, read = read_from(reader)](const IndexEntry& entry) -> Result<LoadedTile> {
      if (!is_up) return failed(to_string(entry.id) + ": the network is down");
      return read(entry);
    };
    auto terrain = Terrain::open(reader, options_of(), failing);
    REQUIRE(terrain.ok());
    if (!fails_from_the_start) {
      ViewState elsewhere = home();
      elsewhere.eye = {-100, -30};
      settle(*terrain, elsewhere);
      is_up = false;
    }
    std::vector<std::string> messages;
    const RenderList& during = settle(*terrain, home(), messages);
    CHECK_FALSE(during.is_complete);
    CHECK_FALSE(messages.empty());
    CHECK(std::set<std::string>(messages.begin(), messages.end()).size() == messages.size());
    CHECK(terrain->stats().tiles_damaged == 0);
    is_up = true;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    const RenderList* list = &terrain->update(home(), 0.01);
    while (!list->is_complete && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      list = &terrain->update(home(), 0.01);
    }
    CHECK(list->is_complete);
    CHECK(sources_of(*list) == expected);
    CHECK(terrain->stats().holes == 0);
  }
}

TEST_CASE("asynchronous reads give the map that worker threads give") {
  const FlightPack pack;
  const auto reader = pack.open();
  PendingReads reads;
  auto terrain = Terrain::open(reader, options_of(), reads.source(read_from(reader)));
  REQUIRE(terrain.ok());
  const RenderList* list = &terrain->update(home(), 0.01);
  for (int i = 0; i < 10000 && !list->is_complete; ++i) {
    reads.answer();
    list = &terrain->update(home(), 0.01);
  }
  REQUIRE(list->is_complete);
  CHECK(sources_of(*list) == sources_at_home(reader));
}

TEST_CASE("asynchronous reads that are no longer needed are asked to stop, and read later if they are") {
  const FlightPack pack;
  const auto reader = pack.open();
  PendingReads reads;
  auto terrain = Terrain::open(reader, options_of(), reads.source(read_from(reader)));
  REQUIRE(terrain.ok());
  terrain->update(home(), 0.01);
  reads.answer();  // the root
  for (int i = 0; i < 3; ++i) {
    terrain->update(home(), 0.01);
    reads.answer();
  }
  terrain->update(home(), 0.01);  // asks for finer tiles
  ViewState elsewhere = home();
  elsewhere.eye = {-100, -30};
  elsewhere.height_m = 1e9;
  terrain->update(elsewhere, 0.01);
  CHECK(reads.answer() > 0);
  std::vector<std::string> messages;
  const RenderList* list = &terrain->update(home(), 0.01);
  for (int i = 0; i < 10000 && !list->is_complete; ++i) {
    reads.answer();
    list = &terrain->update(home(), 0.01);
    for (const Error& error : list->errors) messages.push_back(error.message);
  }
  CHECK(list->is_complete);
  CHECK(messages.empty());
  CHECK(terrain->stats().reads_failed == 0);
}

TEST_CASE("a terrain ends at once beside reads that do not, and their results are dropped") {
  const FlightPack pack;
  const auto reader = pack.open();
  PendingReads reads;
  {
    auto terrain = Terrain::open(reader, options_of(), reads.source(read_from(reader)));
    REQUIRE(terrain.ok());
    terrain->update(home(), 0.01);
  }
  auto pending = reads.take();
  REQUIRE_FALSE(pending.empty());
  for (auto& each : pending) {
    CHECK(each.stop.stop_requested());
    each.done(read_from(reader)(each.entry));
    each.done(failed("again"));
  }
}

TEST_CASE("an asynchronous read that is dropped, throws, or answers from another thread") {
  const FlightPack pack;
  const auto reader = pack.open();
  std::atomic<int> calls = 0;
  std::vector<std::jthread> threads;
  const auto unreliable = [&](const IndexEntry& entry, const std::stop_token&, TileDone done) {
    const int call = ++calls;
    if (call % 7 == 0) return;  // dropped
    if (call % 7 == 1) throw std::runtime_error("no socket");
    threads.emplace_back([&reader, entry, done = std::move(done)] { done(read_from(reader)(entry)); });
  };
  {
    auto terrain = Terrain::open(reader, options_of(), RequestTile(unreliable));
    REQUIRE(terrain.ok());
    const RenderList& list = settle(*terrain, home());
    CHECK(list.is_complete);
    CHECK(sources_of(list) == sources_at_home(reader));
    CHECK(terrain->stats().reads_failed > 0);
  }
}

TEST_CASE("a view out of range is said once, and what was drawn stays") {
  const FlightPack pack;
  auto terrain = Terrain::open(pack.open(), options_of());
  REQUIRE(terrain.ok());
  const Sources before = sources_of(settle(*terrain, home()));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto refused = [&](const char* name, auto change) {
    ViewState view = home();
    double dt_s = 0.01;
    change(view, dt_s);
    const RenderList& list = terrain->update(view, dt_s);
    REQUIRE(list.errors.size() == 1);
    CHECK(list.errors[0].code == ErrorCode::usage);
    CHECK(list.errors[0].message.find(std::string("view: ") + name + ": expected ") == 0);
    CHECK_FALSE(list.is_complete);
    CHECK(sources_of(list) == before);
    CHECK(terrain->update(view, dt_s).errors.empty());
    CHECK(settle(*terrain, home()).is_complete);
  };
  refused("longitude", [](ViewState& v, double&) { v.eye.lon = kNan; });
  refused("latitude", [](ViewState& v, double&) { v.eye.lat = kInfinite; });
  refused("latitude", [](ViewState& v, double&) { v.eye.lat = 95; });
  refused("height", [](ViewState& v, double&) { v.height_m = -kInfinite; });
  refused("height", [](ViewState& v, double&) { v.height_m = 1e300; });
  refused("heading", [](ViewState& v, double&) { v.heading_deg = kNan; });
  refused("pitch", [](ViewState& v, double&) { v.pitch_deg = kNan; });
  refused("roll", [](ViewState& v, double&) { v.roll_deg = kInfinite; });
  refused("field of view", [](ViewState& v, double&) { v.fov_y_deg = 0; });
  refused("field of view", [](ViewState& v, double&) { v.fov_y_deg = 180; });
  refused("viewport width", [](ViewState& v, double&) { v.viewport_width_px = 0; });
  refused("viewport height", [](ViewState& v, double&) { v.viewport_height_px = -3; });
  refused("time since the last update", [](ViewState&, double& dt_s) { dt_s = kNan; });
  refused("time since the last update", [](ViewState&, double& dt_s) { dt_s = -1; });
}

TEST_CASE("a budget that does not hold the eye's map is said") {
  const FlightPack pack;
  const auto is_limited = [&](std::uint64_t cache_mib) {
    TerrainOptions options = options_of(cache_mib);
    options.workers = 1;
    auto terrain = Terrain::open(pack.open(), options);
    REQUIRE(terrain.ok());
    const RenderList& list = settle(*terrain, home());
    CHECK(list.is_complete);
    return list.is_limited;
  };
  CHECK(is_limited(16));
  CHECK_FALSE(is_limited(96));
}

}  // namespace cairn
