// Ten thousand flipped bytes: verify finds each, and none makes opening or reading crash.

#include <fstream>
#include <random>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "format/pack_verify.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

/// Three tiles with voids, plain and constant, two levels: small, so that ten thousand are quick.
void write_small_pack(const std::filesystem::path& path) {
  const auto height = [](std::int64_t column, std::int64_t row) {
    return column <= 9 * 256 ? 300 : static_cast<std::int32_t>(300 + column % 9 + row % 7 - 9 * 256 % 9);
  };
  const auto is_void = [](std::int64_t column, std::int64_t) { return column > 10 * 256 - 20; };
  test::write_test_pack(path, {257, 2, height, is_void}, {{1, 4, 2}, {2, 8, 4}, {2, 9, 4}});
}

void read_everything(const PackReader& pack) {
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::heights) {
      (void)pack.read_height_tile(entry);
    } else {
      (void)pack.read_block(entry);
    }
  }
}

}  // namespace

TEST_CASE("each of 10,000 random byte flips of a pack is found by verify and crashes no reader") {
  const test::TempDir dir;
  const auto path = dir.path() / "a.cairn";
  write_small_pack(path);
  const auto clean = verify_pack(path);
  REQUIRE((clean.ok() && clean->ok()));
  auto bytes = test::read_bytes(path);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t at) {
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(bytes[at]));
    file.flush();
  };
  std::mt19937 random(42);
  for (int i = 0; i < 10000; ++i) {
    const std::size_t at = random() % bytes.size();
    const std::byte flip{static_cast<unsigned char>(1 + random() % 255)};
    bytes[at] ^= flip;
    put(at);
    INFO("byte " << at << " of " << bytes.size());
    const auto report = verify_pack(path, {1, 1});
    REQUIRE((report.ok() && !report->ok()));
    if (const auto pack = PackReader::open(path); pack && i % 16 == 0) read_everything(*pack);
    bytes[at] ^= flip;
    put(at);
  }
}

}  // namespace cairn
