// Any bytes as a page of an index and as a root. What is accepted is in range, and encodes to a page that
// decodes to equal rows.

#include <catch2/catch.hpp>

#include "format/index_page.h"
#include "format/zstd_frame.h"
#include "tests/support/fuzz.h"

namespace cairn {
namespace {

std::vector<std::byte> leaf() {
  std::vector<IndexEntry> entries;
  std::uint64_t offset = kPackStartBytes;
  for (std::int32_t i = 0; i < 40; ++i) {
    IndexEntry entry;
    entry.id = {2, 2 * i, 3};
    entry.min_quanta = -i;
    entry.max_quanta = i * i;
    entry.geometric_error_m = 0.25f * static_cast<float>(i);
    entry.filled = static_cast<std::uint16_t>(i);
    if (i % 3 == 0) {
      entry.flags = kConstant;
      entry.max_quanta = entry.min_quanta;
    } else {
      entry.offset = offset;
      entry.bytes = 1000;
      entry.checksum = 1;
      offset += entry.bytes;
    }
    entries.push_back(entry);
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return encode_leaf_page(entries);
}

std::vector<std::byte> branch() {
  std::vector<ChildPage> children;
  for (std::uint64_t i = 0; i < 40; ++i) children.push_back({100 * i, i + 1, 50'000 + 9000 * i, 9000, i});
  return encode_branch_page(2, children);
}

void use(const IndexPage& page) {
  if (page.keys.empty()) return;
  const auto again = decode_index_page(page.height == 0 ? encode_leaf_page(page.entries)
                                                        : encode_branch_page(page.height, page.children));
  REQUIRE(again.ok());
  REQUIRE(again->entries == page.entries);
  REQUIRE(again->children == page.children);
}

/// The input as a page, and as the columns of a page whose frame is whole: damage rarely leaves one.
void index_page(std::span<const std::byte> input) {
  if (const auto page = decode_index_page(input)) use(*page);
  if (const auto root = decode_root(input)) use(root->page);
  if (input.size() < 4) return;
  const auto columns = input.subspan(4, std::min<std::size_t>(input.size() - 4, 8000));
  std::vector<std::byte> frame;
  append_zstd_frame(columns, {}, frame);
  std::vector<std::byte> page(input.begin(), input.begin() + 4);
  page[1] = std::byte{0};
  for (const std::size_t count : {frame.size(), columns.size()}) {
    page.push_back(static_cast<std::byte>(count & 255));
    page.push_back(static_cast<std::byte>(count >> 8));
  }
  page.insert(page.end(), frame.begin(), frame.end());
  page.resize(page.size() + 8 * (std::to_integer<std::size_t>(input[2]) % 64));
  if (const auto decoded = decode_index_page(page)) use(*decoded);
}

}  // namespace

TEST_CASE("no bytes make reading a page of an index crash, and what is read is in range") {
  std::vector<PackLevel> levels{{Layer::heights, 2, 1.0f, 27, 3, 50}};
  test::run_fuzz("index_page", index_page, {leaf(), branch(), encode_root(levels, leaf())}, 20000);
}

}  // namespace cairn
