#include "format/pack_writer.h"

#include <algorithm>
#include <csignal>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cairn/pack_reader.h"
#include "format/tile_number.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> noise(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> block(bytes);
  for (std::byte& b : block) b = static_cast<std::byte>(random());
  return block;
}

IndexEntry plain_entry(std::int32_t x) {
  IndexEntry entry;
  entry.id = {0, x, 3};
  return entry;
}

std::vector<IndexEntry> entries_of(const PackWriter& writer) {
  std::vector<IndexEntry> entries;
  REQUIRE(writer.visit_entries([&](const IndexEntry& entry) -> Status {
    entries.push_back(entry);
    return {};
  }));
  return entries;
}

Result<PackWriter> reopened(const fs::path& target, const std::vector<IndexEntry>& entries) {
  return PackWriter::reopen(target, test::test_header(), [&](const PackWriter::TakeEntry& take) -> Status {
    for (const IndexEntry& entry : entries) {
      if (Status status = take(entry); !status) return status;
    }
    return {};
  });
}

PackWriter started(const fs::path& target) {
  Result<PackWriter> writer = PackWriter::create(target, test::test_header());
  REQUIRE(writer.ok());
  return std::move(*writer);
}

}  // namespace

TEST_CASE("the target appears only when the pack is finished, and the part is gone then") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  const fs::path part = dir.path() / "a.cairn.part";
  {
    PackWriter writer = started(target);
    REQUIRE(writer.add(plain_entry(1), noise(100, 1)).ok());
  }
  CHECK_FALSE(fs::exists(target));
  REQUIRE(fs::exists(part));
  CHECK_FALSE(PackReader::open(part).ok());
  PackWriter writer = started(target);
  REQUIRE(writer.add(plain_entry(1), noise(100, 1)).ok());
  REQUIRE(writer.finish("{}").ok());
  CHECK_FALSE(fs::exists(part));
  CHECK(PackReader::open(target).ok());
}

TEST_CASE("an abandoned pack leaves nothing") {
  const test::TempDir dir;
  PackWriter writer = started(dir.path() / "a.cairn");
  REQUIRE(writer.add(plain_entry(1), noise(100, 1)).ok());
  writer.abandon();
  CHECK(fs::is_empty(dir.path()));
}

TEST_CASE("equal blocks are stored once, whether still buffered or long on the disk") {
  const test::TempDir dir;
  PackWriter writer = started(dir.path() / "a.cairn");
  const auto first = writer.add(plain_entry(0), noise(1000, 0));
  const auto buffered = writer.add(plain_entry(1), noise(1000, 0));
  REQUIRE((first.ok() && buffered.ok()));
  CHECK(buffered->offset == first->offset);
  for (int i = 2; i < 8; ++i) {
    REQUIRE(writer.add(plain_entry(i), noise(700000, static_cast<unsigned>(i))).ok());
  }
  const std::uint64_t before = writer.position();
  const auto on_disk = writer.add(plain_entry(8), noise(1000, 0));
  const auto large = writer.add(plain_entry(9), noise(700000, 3));
  REQUIRE((on_disk.ok() && large.ok()));
  CHECK(on_disk->offset == first->offset);
  CHECK(large->offset == entries_of(writer)[3].offset);
  CHECK((first->flags & kSharedBlock) == 0);
  for (const auto& shared : {buffered, on_disk, large}) CHECK((shared->flags & kSharedBlock) != 0);
  CHECK(writer.position() == before);
  CHECK(before == kPackStartBytes + 1000 + 6 * 700000);
}

TEST_CASE("blocks larger than the write buffer come back whole") {
  const test::TempDir dir;
  PackWriter writer = started(dir.path() / "a.cairn");
  for (int i = 0; i < 3; ++i) {
    REQUIRE(writer.add(plain_entry(i), noise(3'000'000u + static_cast<unsigned>(i), 9)).ok());
  }
  REQUIRE(writer.finish("{}").ok());
  const auto reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  for (std::size_t i = 0; i < 3; ++i) {
    const auto block = reader->read_block(reader->entry(i));
    REQUIRE(block.ok());
    CHECK(*block == noise(3'000'000u + static_cast<unsigned>(i), 9));
  }
}

TEST_CASE("a pack taken up again after a break has the same bytes as one written at once") {
  const test::TempDir dir;
  const auto add = [](PackWriter& writer, int from, int to) {
    for (int i = from; i < to; ++i) {
      REQUIRE(writer.add(plain_entry(i), noise(5000, static_cast<unsigned>(i % 7))).ok());
    }
  };
  PackWriter whole = started(dir.path() / "whole.cairn");
  add(whole, 0, 20);
  REQUIRE(whole.finish("{}").ok());

  const fs::path target = dir.path() / "broken.cairn";
  std::vector<IndexEntry> kept;
  {
    PackWriter broken = started(target);
    add(broken, 0, 12);
    REQUIRE(broken.flush().ok());
    kept = entries_of(broken);
    kept.resize(5);
  }
  auto again = reopened(target, kept);
  REQUIRE(again.ok());
  CHECK(again->position() == kPackStartBytes + 5 * 5000);
  add(*again, 5, 20);
  REQUIRE(again->finish("{}").ok());
  CHECK(test::read_bytes(target) == test::read_bytes(dir.path() / "whole.cairn"));
}

TEST_CASE("a part that is shorter than its journal says cannot be taken up") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  std::vector<IndexEntry> entries;
  {
    PackWriter writer = started(target);
    REQUIRE(writer.add(plain_entry(1), noise(5000, 1)).ok());
    entries = entries_of(writer);  // never flushed
  }
  const auto again = reopened(target, entries);
  REQUIRE_FALSE(again.ok());
  CHECK(again.error().code == ErrorCode::bad_data);
  CHECK_THAT(again.error().message, Catch::Contains("21384"));
}

TEST_CASE("a tile that was added twice fails the pack") {
  const test::TempDir dir;
  PackWriter writer = started(dir.path() / "a.cairn");
  REQUIRE(writer.add(plain_entry(4), noise(10, 1)).ok());
  REQUIRE(writer.add(plain_entry(4), noise(10, 2)).ok());
  const Status status = writer.finish("{}");
  REQUIRE_FALSE(status.ok());
  CHECK_THAT(status.error().message, Catch::Contains("0/4/3 was added twice"));
  CHECK_FALSE(fs::exists(dir.path() / "a.cairn"));
}

TEST_CASE("the entries of many thousand tiles come out in the order of the index, however they were added") {
  const test::TempDir dir;
  std::vector<std::int32_t> order(200'000);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  PackWriter writer = started(dir.path() / "a.cairn");
  for (const std::int32_t number : order) {
    IndexEntry entry;
    entry.flags = kConstant;
    entry.layer = number % 5 == 0 ? Layer::imagery : Layer::heights;
    entry.id = {2 + number % 2, number % 499, number / 499};
    entry.min_quanta = entry.max_quanta = number;
    REQUIRE(writer.add(entry, {}).ok());
  }
  CHECK(fs::directory_iterator(dir.path()) != fs::directory_iterator());
  CHECK(std::distance(fs::directory_iterator(dir.path()), {}) == 1);  // the scratch file has no name
  const auto entries = entries_of(writer);
  REQUIRE(entries.size() == order.size());
  CHECK(std::is_sorted(entries.begin(), entries.end(),
                       [](const auto& a, const auto& b) { return index_key_of(a) < index_key_of(b); }));
  REQUIRE(writer.finish("{}").ok());
  const auto reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  REQUIRE(reader->read_index().ok());
  REQUIRE(reader->entry_count() == entries.size());
  for (std::size_t i = 0; i < entries.size(); i += 7) {
    REQUIRE(reader->entry(i) == entries[i]);
    REQUIRE(reader->find_index(entries[i].layer, entries[i].id) == i);
  }
  std::uint64_t tiles = 0;
  for (const PackLevel& level : reader->level_table()) tiles += level.tiles;
  CHECK(tiles == entries.size());
}

TEST_CASE("a folder that is not there or cannot be written gives an error that names the file") {
  const test::TempDir dir;
  const auto missing = PackWriter::create(dir.path() / "no" / "a.cairn", test::test_header());
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().code == ErrorCode::failed);
  CHECK_THAT(missing.error().message, Catch::Contains("no/a.cairn.part: create: No such file"));
  const auto forbidden = PackWriter::create("/proc/a.cairn", test::test_header());
  CHECK_FALSE(forbidden.ok());
}

TEST_CASE("two writers cannot have the same target") {
  const test::TempDir dir;
  PackWriter first = started(dir.path() / "a.cairn");
  const auto second = PackWriter::create(dir.path() / "a.cairn", test::test_header());
  REQUIRE_FALSE(second.ok());
  CHECK_THAT(second.error().message, Catch::Contains("another process is writing it"));
}

TEST_CASE("a write past what the file system takes fails with the file's name and leaves no target") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  // RLIMIT_FSIZE stands in for a full disk: the same short writes, then an error, without a disk to fill.
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 20, 1 << 20};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto writer = PackWriter::create(target, test::test_header());
    Status status;
    for (int i = 0; status && i < 8; ++i) {
      const auto added = writer->add(plain_entry(i), noise(300000, static_cast<unsigned>(i)));
      if (!added) status = added.error();
    }
    if (status) status = writer->finish("{}");
    const bool told = !status && status.error().code == ErrorCode::failed &&
                      status.error().message.find("a.cairn.part: write at") != std::string::npos;
    ::_exit(told ? 0 : 1);
  }
  int result = -1;
  REQUIRE(::waitpid(child, &result, 0) == child);
  CHECK(result == 0);
  CHECK_FALSE(fs::exists(target));
}

}  // namespace cairn
