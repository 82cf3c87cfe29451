// The journal of a bake: round trips, and what is left of it after every cut and every flipped byte.

#include "builder/bake/journal.h"

#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kPrint = 0x0123456789abcdef;

UnitRecord record_of(int number) {
  UnitRecord record;
  for (int i = 0; i <= number % 2; ++i) {
    IndexEntry entry;
    entry.id = {2, 10 * number + i, 7};
    entry.offset = kPackStartBytes + static_cast<std::uint64_t>(100 * number + i);
    entry.bytes = 1;
    entry.min_quanta = -number;
    entry.max_quanta = number;
    record.entries.push_back(entry);
  }
  if (number == 2)
    record.held = TileBlock{{.flags = kConstant, .id = {1, 5, 3}, .min_quanta = 9, .max_quanta = 9}, {}};
  if (number == 3) record.held = TileBlock{{.id = {1, 6, 3}, .max_quanta = 9}, {std::byte{1}, std::byte{7}}};
  for (int i = 0; i < 5 * number; ++i) record.root.push_back(static_cast<std::byte>(i * number));
  return record;
}

void write_journal(const fs::path& target, int records) {
  auto journal = Journal::create(target);
  REQUIRE(journal.ok());
  CHECK(journal->is_empty());
  for (int r = 0; r < records; ++r) REQUIRE(journal->append(record_of(r)).ok());
  REQUIRE(journal->identify(kPrint).ok());
}

bool equal(const UnitRecord& record, int number) {
  const UnitRecord expected = record_of(number);
  if (record.held.has_value() != expected.held.has_value()) return false;
  if (record.held &&
      (record.held->entry.id != expected.held->entry.id ||
       record.held->entry.flags != expected.held->entry.flags || record.held->block != expected.held->block))
    return false;
  return record.entries == expected.entries && record.root == expected.root;
}

// Where the records are, each of which has to be the one that was written.
std::vector<RecordPlace> places_in(const fs::path& target, std::uint64_t print = kPrint) {
  int number = 0;
  const auto places = Journal::find_records(target, print, [&number](const UnitRecord& record) {
    if (!equal(record, number)) FAIL("record " << number << " is another one");
    ++number;
    return true;
  });
  return places;
}

std::size_t count_read(const fs::path& target) {
  return places_in(target).size();
}

}  // namespace

TEST_CASE("a journal gives back its records and their roots, and goes on after the last of those kept") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  write_journal(target, 4);
  CHECK(count_read(target) == 4);
  CHECK(places_in(target, kPrint + 1).empty());
  CHECK(places_in(dir.path() / "b.cairn").empty());
  int asked = 0;
  CHECK(Journal::find_records(target, kPrint, [&asked](const UnitRecord&) { return ++asked < 3; }).size() ==
        2);

  auto records = places_in(target);
  records.resize(2);
  auto journal = Journal::reopen(target, records);
  REQUIRE(journal.ok());
  CHECK_FALSE(journal->is_empty());
  CHECK(count_read(target) == 2);
  REQUIRE(journal->append(record_of(2)).ok());
  records = places_in(target);
  REQUIRE(records.size() == 3);
  for (int r = 0; r < 3; ++r) {
    const auto record = journal->read(records[static_cast<std::size_t>(r)]);
    REQUIRE(record.ok());
    CHECK(equal(*record, r));
  }
}

TEST_CASE("a journal that was never identified is nobody's") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  auto journal = Journal::create(target);
  REQUIRE(journal.ok());
  REQUIRE(journal->append(record_of(1)).ok());
  CHECK_FALSE(journal->is_empty());
  CHECK(places_in(target).empty());
  CHECK(places_in(target, 0).empty());
}

TEST_CASE("a journal cut anywhere gives the records before the cut") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  write_journal(target, 4);
  std::vector<std::uint64_t> ends{0};
  for (const RecordPlace& place : places_in(target)) ends.push_back(place.end);
  const auto bytes = test::read_bytes(Journal::path_for(target));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    test::write_bytes(Journal::path_for(target),
                      {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    std::size_t whole = 0;
    while (whole + 1 < ends.size() && ends[whole + 1] <= size) ++whole;
    if (count_read(target) != whole) FAIL("cut at byte " << size);
  }
}

TEST_CASE("a flipped byte of a journal costs its record and those after it, and never changes one") {
  const test::TempDir dir;
  const fs::path target = dir.path() / "a.cairn";
  write_journal(target, 3);
  const auto records = places_in(target);
  const auto bytes = test::read_bytes(Journal::path_for(target));
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const int flip = at % 3 == 0 ? 0x01 : at % 3 == 1 ? 0x80 : 0xff;
    auto damaged = bytes;
    damaged[at] ^= static_cast<std::byte>(flip);
    test::write_bytes(Journal::path_for(target), damaged);
    std::size_t before = 0;
    while (before < records.size() && records[before].end <= at) ++before;
    if (count_read(target) != before) FAIL("byte " << at << " flipped by " << flip);
  }
}

}  // namespace cairn
