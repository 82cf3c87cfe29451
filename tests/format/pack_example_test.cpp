// docs/pack-format.md shows a whole pack in hexadecimal: here it is opened, so that the page stays true.

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "format/height_block.h"
#include "format/pack_verify.h"
#include "format/pack_writer.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr std::string_view kMetadata = R"({"cairn":"example"})";

/// The sea with a rock of 10 m in the middle: 40 quanta of a quarter of a metre.
HeightTile rock() {
  HeightTile tile{257, std::vector<std::int32_t>(257 * 257, 0), {}};
  tile.samples[128 * 257 + 128] = 40;
  return tile;
}

/// The rock at 1/417/253 and a constant tile of -10 m at 1/419/253, as the page has it.
void write_example(const std::filesystem::path& path) {
  Result<PackWriter> writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  IndexEntry child = test::describe({1, 417, 253}, rock());
  child.geometric_error_m = 0.5f;
  REQUIRE(writer->add(child, encode_height_block(rock(), *find_height_codec(1))).ok());
  IndexEntry other;
  other.flags = kConstant;
  other.id = {1, 419, 253};
  other.min_quanta = other.max_quanta = -40;
  REQUIRE(writer->add(other, {}).ok());
  REQUIRE(writer->finish(kMetadata).ok());
}

/// Lines of sixteen bytes; `*` stands for lines of zeros up to the next line's offset.
std::string dump(const std::vector<std::byte>& bytes) {
  std::string text;
  char piece[32];
  bool is_gap = false;
  for (std::size_t i = 0; i < bytes.size(); i += 16) {
    const auto line = std::span(bytes).subspan(i, std::min<std::size_t>(16, bytes.size() - i));
    const bool is_blank =
        std::all_of(line.begin(), line.end(), [](std::byte b) { return b == std::byte{0}; });
    if (is_blank && i + 16 < bytes.size()) {
      if (!is_gap) text += "*\n";
      is_gap = true;
      continue;
    }
    is_gap = false;
    std::snprintf(piece, sizeof piece, "%04zx ", i);
    text += piece;
    for (const std::byte b : line) {
      std::snprintf(piece, sizeof piece, " %02x", std::to_integer<unsigned>(b));
      text += piece;
    }
    text += "\n";
  }
  return text;
}

/// The bytes of the page's hexadecimal block, as dump() writes them.
std::vector<std::byte> bytes_of_page() {
  std::ifstream page(test::sample_dem().parent_path() / "docs" / "pack-format.md");
  REQUIRE(page.is_open());
  std::vector<std::byte> bytes;
  std::string line;
  while (std::getline(page, line) && line != "```hex") {
  }
  bool is_gap = false;
  while (std::getline(page, line) && line != "```") {
    if (line == "*") {
      is_gap = true;
      continue;
    }
    std::istringstream words(line);
    std::string word;
    words >> word;
    const std::size_t offset = std::stoul(word, nullptr, 16);
    if (is_gap) bytes.resize(std::max(bytes.size(), offset));
    is_gap = false;
    CHECK(offset == bytes.size());
    while (words >> word) bytes.push_back(static_cast<std::byte>(std::stoul(word, nullptr, 16)));
  }
  return bytes;
}

}  // namespace

TEST_CASE("the pack that docs/pack-format.md shows is one, and holds what the page says") {
  const test::TempDir dir;
  const auto path = dir.path() / "page.cairn";
  test::write_bytes(path, bytes_of_page());
  const auto report = verify_pack(path);
  REQUIRE(report.ok());
  for (const Finding& finding : report->findings) FAIL_CHECK(finding.where << ": " << finding.what);
  const auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  CHECK(pack->metadata_json() == kMetadata);
  CHECK(pack->header().tile_size == 257);
  CHECK(pack->header().quantum_m == 0.25);
  CHECK(pack->header().vertical_datum == VerticalDatum::egm96);
  REQUIRE(pack->entry_count() == 2);
  const auto tile = pack->read_height_tile(pack->entry(0));
  REQUIRE(tile.ok());
  CHECK(tile->samples == rock().samples);
  const IndexEntry constant = pack->entry(1);
  CHECK(constant.id == TileId{1, 419, 253});
  CHECK(constant.min_quanta == -40);
}

TEST_CASE("print the pack that docs/pack-format.md shows", "[.print]") {
  const test::TempDir dir;
  write_example(dir.path() / "a.cairn");
  std::fputs(dump(test::read_bytes(dir.path() / "a.cairn")).c_str(), stdout);
}

}  // namespace cairn
