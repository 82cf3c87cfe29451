// Packs over HTTP from a local server that fails in every way a network can: right heights or one clear
// error.

#include "cairn/remote_pack.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <catch2/catch.hpp>

#include "cairn/pack_sampler.h"
#include "format/pack_writer.h"
#include "tests/support/range_server.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

const test::TestSurface kHills{257, 2, test::hills, {}};
const std::vector<TileId> kTiles =
    test::with_ancestors({{2, 8, 4}, {2, 9, 4}, {2, 8, 5}, {2, 9, 5}, {2, 10, 6}}, 0);

/// A pack on a server, its cache, and what is read of it.
struct Remote {
  test::TempDir dir;
  fs::path folder = dir.path() / "served";
  fs::path cache = dir.path() / "cache";
  fs::path file = folder / "a.cairn";
  RemoteOptions options;

  Remote() {
    fs::create_directories(folder);
    test::write_test_pack(file, kHills, kTiles);
    options.cache_folder = cache;
    options.attempts = 3;
    options.timeout_s = 10;
  }
  Result<PackReader> open(const test::RangeServer& server, const std::string& fault) const {
    return open_pack(server.address(fault, "a.cairn"), options);
  }
};

/// Reads every tile. The first error; else each has to be as it was written.
Status read_tiles(const PackReader& pack) {
  for (const TileId& id : kTiles) {
    const auto entry = pack.find(Layer::heights, id);
    REQUIRE(entry);
    const auto tile = pack.read_height_tile(*entry);
    if (!tile) return tile.error();
    REQUIRE(tile->samples == kHills.tile(id).samples);
  }
  return {};
}

Status open_and_read(const Remote& remote, const test::RangeServer& server, const std::string& fault) {
  const auto pack = remote.open(server, fault);
  if (!pack) return pack.error();
  if (Status status = read_tiles(*pack); !status) return status;
  return pack->read_metadata();
}

int ranges_asked(const test::RangeServer& server) {
  const std::string address = server.address("", "");
  const std::string count = address.substr(0, address.size() - 2) + "/count";
  FILE* pipe = ::popen(("/usr/bin/python3 -c \"import urllib.request; print(urllib.request.urlopen('" +
                        count + "').read().decode())\"")
                           .c_str(),
                       "r");
  REQUIRE(pipe != nullptr);
  int number = -1;
  REQUIRE(std::fscanf(pipe, "%d", &number) == 1);
  ::pclose(pipe);
  return number;
}

}  // namespace

TEST_CASE(
    "a pack over HTTP gives its tiles and metadata, also late, in pieces, at another try, after a move") {
  for (const char* fault : {"ok", "slow", "short", "flaky", "garbled", "tagged", "moved"}) {
    INFO(fault);
    const Remote remote;
    const test::RangeServer server(remote.folder);
    const Status status = open_and_read(remote, server, fault);
    INFO((status ? "" : status.error().message));
    CHECK(status.ok());
  }
}

TEST_CASE("what a network does wrong for good is one clear error, and no height") {
  const std::pair<const char*, const char*> faults[] = {{"gone", "HTTP status 404"},
                                                        {"denied", "HTTP status 403"},
                                                        {"broken", "HTTP status 500, at 3 attempts"},
                                                        {"cut", "at 3 attempts"},
                                                        {"whole", "one that sends whole files"},
                                                        {"packed", "packed by gzip on the way"},
                                                        {"shifted", "found bytes bytes 1-16383"},
                                                        {"unsaid", "a Content-Range"},
                                                        {"shrunk", "found a shorter file"},
                                                        {"poisoned", "checksum"}};
  for (const auto& [fault, words] : faults) {
    INFO(fault);
    const Remote remote;
    const test::RangeServer server(remote.folder);
    const Status status = open_and_read(remote, server, fault);
    REQUIRE_FALSE(status.ok());
    CHECK_THAT(status.error().message, Catch::StartsWith(server.address(fault, "a.cairn") + ": "));
    CHECK_THAT(status.error().message, Catch::Contains(words));
    CHECK(status.error().message.find('\n') == std::string::npos);
  }
}

TEST_CASE("more bytes than were asked for, no server, no such host and no pack are errors") {
  const Remote remote;
  std::string dead;
  {
    const test::RangeServer server(remote.folder);
    dead = server.address("ok", "a.cairn");
    CHECK_FALSE(open_and_read(remote, server, "longer").ok());
    CHECK_THAT(open_pack(server.address("ok", "none.cairn"), remote.options).error().message,
               Catch::Contains("404"));
    test::write_bytes(remote.folder / "text", std::vector<std::byte>(40000, std::byte{'x'}));
    CHECK_THAT(open_pack(server.address("ok", "text"), remote.options).error().message,
               Catch::Contains("magic"));
    test::write_bytes(remote.folder / "empty", {});
    CHECK_FALSE(open_pack(server.address("ok", "empty"), remote.options).ok());
  }
  const auto gone = open_pack(dead, remote.options);
  REQUIRE_FALSE(gone.ok());
  CHECK(gone.error().code == ErrorCode::failed);
  CHECK_FALSE(open_pack("http://no-such-host.invalid/a.cairn", remote.options).ok());
  CHECK_FALSE(open_pack("https://127.0.0.1:1/a.cairn", remote.options).ok());
}

TEST_CASE("parts that were read come from the disk, and a tile's siblings come in its request") {
  const Remote remote;
  const test::RangeServer server(remote.folder);
  {
    const auto pack = remote.open(server, "ok");
    REQUIRE(pack.ok());
    CHECK(ranges_asked(server) == 1);
    for (const TileId& id : {TileId{2, 8, 4}, TileId{2, 9, 4}, TileId{2, 8, 5}, TileId{2, 9, 5}})
      REQUIRE(pack->read_height_tile(*pack->find(Layer::heights, id)).ok());
    CHECK(ranges_asked(server) <= 2);
    REQUIRE(read_tiles(*pack).ok());
  }
  (void)ranges_asked(server);
  const auto again = remote.open(server, "ok");
  REQUIRE(again.ok());
  REQUIRE(read_tiles(*again).ok());
  CHECK(ranges_asked(server) == 1);  // header and root: is it the pack that it was?
}

TEST_CASE(
    "a damaged or missing part of the cache is asked for again, and nothing is kept where none is wanted") {
  Remote remote;
  const test::RangeServer server(remote.folder);
  REQUIRE(open_and_read(remote, server, "ok").ok());
  std::size_t parts = 0;
  for (const auto& file : fs::recursive_directory_iterator(remote.cache)) {
    if (!file.is_regular_file()) continue;
    auto bytes = test::read_bytes(file.path());
    bytes[++parts % bytes.size()] ^= std::byte{1};
    test::write_bytes(file.path(), bytes);
  }
  CHECK(parts >= kTiles.size());
  REQUIRE(open_and_read(remote, server, "ok").ok());
  fs::remove_all(remote.cache);
  remote.options.cache_bytes = 0;
  REQUIRE(open_and_read(remote, server, "ok").ok());
  CHECK_FALSE(fs::exists(remote.cache));
  remote.options.cache_bytes = 1 << 30;
  remote.options.cache_folder = "/proc/no-such-folder";
  CHECK(open_and_read(remote, server, "ok").ok());
}

TEST_CASE("the cache stays within its bytes") {
  Remote remote;
  const test::RangeServer server(remote.folder);
  remote.options.cache_bytes = 200'000;
  REQUIRE(open_and_read(remote, server, "ok").ok());
  std::uint64_t bytes = 0;
  for (const auto& file : fs::recursive_directory_iterator(remote.cache)) {
    if (file.is_regular_file()) bytes += file.file_size();
  }
  CHECK(bytes > 0);
  CHECK(bytes <= remote.options.cache_bytes);
}

TEST_CASE("a file that is replaced while it is open is noticed, and its parts are never mixed") {
  for (const char* fault : {"ok", "tagged"}) {
    for (const bool same_size : {false, true}) {
      INFO(fault << " " << same_size);
      const Remote remote;
      const test::RangeServer server(remote.folder);
      const auto pack = remote.open(server, fault);
      REQUIRE(pack.ok());
      REQUIRE(pack->read_height_tile(*pack->find(Layer::heights, {0, 2, 1})).ok());
      if (same_size) {
        auto bytes = test::read_bytes(remote.file);
        for (std::size_t i = kPackHeaderBytes; i < bytes.size(); i += 5) bytes[i] ^= std::byte{1};
        test::write_bytes(remote.file, bytes);
      } else {
        test::write_test_pack(remote.file, {257, 2, [](auto c, auto r) { return test::hills(c + 1, r); }, {}},
                              kTiles);
      }
      const Status status = read_tiles(*pack);
      REQUIRE_FALSE(status.ok());
      CHECK_THAT(status.error().message, Catch::Contains("as it was when it was opened, found another"));
      // What was read before is still there, and is of the old file.
      const auto old = pack->read_height_tile(*pack->find(Layer::heights, {0, 2, 1}));
      REQUIRE(old.ok());
      CHECK(old->samples == kHills.tile({0, 2, 1}).samples);
      if (!same_size) {
        const auto fresh = remote.open(server, fault);
        REQUIRE(fresh.ok());
        const auto tile = fresh->read_height_tile(*fresh->find(Layer::heights, {0, 2, 1}));
        REQUIRE(tile.ok());
        CHECK(tile->samples != old->samples);
      }
    }
  }
}

TEST_CASE("threads share a remote pack; what one asks for another does not ask for again") {
  const Remote remote;
  const test::RangeServer server(remote.folder);
  const auto pack = remote.open(server, "slow");
  REQUIRE(pack.ok());
  (void)ranges_asked(server);
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 6; ++t) {
    threads.emplace_back([&] {
      for (const TileId& id : kTiles) {
        const auto tile = pack->read_height_tile(*pack->find(Layer::heights, id));
        if (!tile || tile->samples != kHills.tile(id).samples) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(ranges_asked(server) <= static_cast<int>(kTiles.size()));
}

TEST_CASE("a file's name and an address are told apart") {
  CHECK(is_remote("http://a/b"));
  CHECK(is_remote("https://a/b"));
  CHECK_FALSE(is_remote("a.cairn"));
  CHECK_FALSE(is_remote("/http://a"));
  CHECK_FALSE(is_remote("ftp://a/b"));
  const Remote remote;
  CHECK(open_pack(remote.file.string()).ok());
  CHECK_THAT(open_pack("/nowhere/a.cairn").error().message, Catch::Contains("No such file"));
}

}  // namespace cairn
