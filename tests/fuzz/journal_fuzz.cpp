// Any bytes are read as the journal of an interrupted bake.
#include <catch2/catch.hpp>

#include "builder/bake/journal.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr std::uint64_t kFingerprint = 0x0123456789ABCDEF;

std::filesystem::path target_in(const TempDir& folder) {
  return folder.path() / "a.cairn";
}

/// The fingerprint of the journal's own bytes is taken, so that records are read whatever it is.
void journal(std::span<const std::byte> input) {
  static const TempDir folder;
  write_bytes(Journal::path_for(target_in(folder)), {input.begin(), input.end()});
  const auto fingerprint = Journal::fingerprint_of(target_in(folder)).value_or(kFingerprint);
  const auto places =
      Journal::find_records(target_in(folder), fingerprint, [](const UnitRecord&) { return true; });
  std::uint64_t end = 0;
  for (const RecordPlace& place : places) {
    REQUIRE(place.start >= end);
    REQUIRE(place.end <= input.size());
    end = place.end;
  }
  if (places.empty()) return;
  const auto reopened = Journal::reopen(target_in(folder), places);
  REQUIRE(reopened);
  for (const RecordPlace& place : places) REQUIRE(reopened->read(place));
}

std::vector<std::byte> seed() {
  const TempDir folder;
  auto made = Journal::create(target_in(folder));
  REQUIRE(made);
  UnitRecord record;
  IndexEntry entry;
  entry.layer = Layer::heights;
  entry.id = {2, 8, 4};
  entry.bytes = 40;
  record.entries = {entry, entry};
  record.root.assign(30, std::byte{7});
  REQUIRE(made->append(record));
  record.entries.clear();
  REQUIRE(made->append(record));
  REQUIRE(made->identify(kFingerprint));
  return read_bytes(Journal::path_for(target_in(folder)));
}

}  // namespace

TEST_CASE("no bytes make reading a journal crash, and its records lie one after another") {
  run_fuzz("journal", journal, {seed()}, 3000);
}

}  // namespace cairn::test
