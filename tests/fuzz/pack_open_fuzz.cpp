// A pack of any bytes is opened, searched, read and verified. Checksums would turn nearly all of them away at
// the door, so each is also tried with header, index and metadata made to fit.

#include <cstring>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/checksum.h"
#include "format/pack_verify.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

using Bytes = std::vector<std::byte>;

void put(Bytes& bytes, std::size_t at, std::span<const std::byte> value) {
  std::copy(value.begin(), value.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

void set_number(Bytes& bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// The metadata ends where the file ends, and id and checksums are right. Offsets are those of
/// docs/pack-format.md.
void make_fit(Bytes& bytes) {
  if (bytes.size() < kPackStartBytes) return;
  std::memcpy(bytes.data(), kPackMagic.data(), kPackMagic.size());
  std::uint64_t metadata = 0;
  std::memcpy(&metadata, bytes.data() + 128, sizeof metadata);
  const auto all = std::span<const std::byte>(bytes);
  if (metadata <= bytes.size()) {
    set_number(bytes, 136, bytes.size() - metadata);
    set_number(bytes, 144, checksum(all.subspan(static_cast<std::size_t>(metadata))));
  }
  set_number(bytes, 160, checksum(all.first(kPackStartBytes).subspan(kPackHeaderBytes)));
  put(bytes, 224, long_checksum(all.first(224)));
  set_number(bytes, 248, checksum(all.first(248)));
}

void use_pack(const std::filesystem::path& path) {
  (void)verify_pack(path, {1, 50});
  const Result<PackReader> pack = PackReader::open(path);
  if (!pack) return;
  (void)pack->read_index();
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
  test::run_fuzz("pack", pack_open, {seed()}, 1000);
}

}  // namespace cairn
