// A pack of any bytes is opened, searched, read and verified. Checksums would turn nearly all of them away at
// the door, so each is also tried with header, index and metadata made to fit.

#include <cstring>

#include <catch2/catch.hpp>

#include "format/checksum.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

using Bytes = std::vector<std::byte>;

std::uint64_t number_at(const Bytes& bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void set_number(Bytes& bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// The checksum of [start, end) goes to `at`, where there is such a range.
void set_checksum(Bytes& bytes, std::size_t at, std::uint64_t start, std::uint64_t end) {
  if (start > end || end > bytes.size()) return;
  set_number(bytes, at, checksum(std::span(bytes).subspan(start, end - start)));
}

/// The metadata ends where the file ends, and the checksums are right. Offsets are those of
/// docs/pack-format.md.
void make_fit(Bytes& bytes) {
  if (bytes.size() < kPackHeaderBytes) return;
  std::memcpy(bytes.data(), kPackMagic.data(), kPackMagic.size());
  const std::uint64_t index = number_at(bytes, 24), metadata = number_at(bytes, 48);
  if (metadata <= bytes.size()) set_number(bytes, 56, bytes.size() - metadata);
  set_checksum(bytes, 40, index, metadata);
  set_checksum(bytes, 64, metadata, bytes.size());
  set_checksum(bytes, 88, 0, 88);
}

void use_pack(const std::filesystem::path& path) {
  (void)verify_pack(path, {1, 50});
  const Result<PackReader> pack = PackReader::open(path);
  if (!pack) return;
  for (std::size_t i = 0; i < pack->entry_count(); ++i) {
    const IndexEntry entry = pack->entry(i);
    (void)pack->find_nearest(entry.layer, entry.id);
    (void)pack->read_block(entry);
  }
  PackSampler sampler(*pack, 1);
  for (const LonLat place : {LonLat{-178, -89}, {180, 90}, {-177.9, -88.9}}) (void)sampler.height_at(place);
}

void pack_open(std::span<const std::byte> input) {
  static const test::TempDir dir;
  const auto path = dir.path() / "fuzz.cairn";
  Bytes bytes(input.begin(), input.end());
  test::write_bytes(path, bytes);
  use_pack(path);
  make_fit(bytes);
  test::write_bytes(path, bytes);
  use_pack(path);
}

/// Three entries, a constant one and two blocks that share a small tile.
Bytes seed() {
  const test::TempDir dir;
  const auto height = [](std::int64_t column, std::int64_t) { return column < 9 * 256 ? 1 : 5; };
  const auto is_void = [](std::int64_t column, std::int64_t) { return column > 9 * 256 + 50; };
  test::write_test_pack(dir.path() / "a.cairn", {257, 2, height, is_void}, {{1, 4, 2}, {2, 8, 4}, {2, 9, 4}});
  return test::read_bytes(dir.path() / "a.cairn");
}

}  // namespace

TEST_CASE("no bytes make opening, searching, reading or verifying a pack crash") {
  test::run_fuzz(pack_open, {seed()}, 1000);
}

}  // namespace cairn
