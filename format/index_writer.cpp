#include "format/index_writer.h"

#include <algorithm>
#include <string>

#include "format/checksum.h"
#include "format/tile_number.h"

namespace cairn {
namespace {

// As many rows as usually fit a page. Where they don't, the page is tried again with half as many.
constexpr std::size_t kUsualRows = 768;

std::size_t root_space(const std::vector<PackLevel>& levels) {
  return kPackStartBytes - kPackHeaderBytes - encode_root(levels, {}).size();
}

}  // namespace

// Takes as many rows from the first on as a page has room for.
template <class Row, class Encode>
Result<ChildPage> IndexWriter::write_page(std::span<const Row> rows, std::size_t& taken,
                                          const Encode& encode) {
  taken = std::min(rows.size(), kUsualRows);
  std::vector<std::byte> page = encode(rows.first(taken));
  while (page.size() > kMostPageBytes) {
    taken /= 2;
    page = encode(rows.first(taken));
  }
  const auto offset = append_(page);
  if (!offset) return offset.error();
  return ChildPage{0, 0, *offset, static_cast<std::uint32_t>(page.size()), checksum(page)};
}

Status IndexWriter::write_leaf() {
  std::size_t taken = 0;
  auto page = write_page(std::span<const IndexEntry>(pending_), taken, encode_leaf_page);
  if (!page) return page.error();
  page->key = index_key_of(pending_.front());
  page->entries = taken;
  pages_.push_back(*page);
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(taken));
  return {};
}

Status IndexWriter::write_branches(int height) {
  std::vector<ChildPage> above;
  for (std::size_t at = 0, taken = 0; at < pages_.size(); at += taken) {
    const auto rest = std::span<const ChildPage>(pages_).subspan(at);
    auto page = write_page(
        rest, taken, [height](std::span<const ChildPage> rows) { return encode_branch_page(height, rows); });
    if (!page) return page.error();
    page->key = rest.front().key;
    for (const ChildPage& child : rest.first(taken)) page->entries += child.entries;
    above.push_back(*page);
  }
  pages_ = std::move(above);
  return {};
}

Status IndexWriter::add(const IndexEntry& entry) {
  pending_.push_back(entry);
  return pending_.size() <= kMostPageRows ? Status() : write_leaf();
}

Result<std::vector<std::byte>> IndexWriter::finish() {
  const std::size_t space = root_space(levels_);
  if (pages_.empty()) {
    const auto page = encode_leaf_page(pending_);
    if (page.size() <= space) return encode_root(levels_, page);
  }
  while (!pending_.empty()) {
    if (const Status status = write_leaf(); !status) return status.error();
  }
  for (int height = 1; height <= kMostPageHeight; ++height) {
    if (pages_.size() <= kMostPageRows) {
      const auto page = encode_branch_page(height, pages_);
      if (page.size() <= space) return encode_root(levels_, page);
    }
    if (const Status status = write_branches(height); !status) return status.error();
  }
  return failed("index: expected at most " + std::to_string(kMostPageHeight) +
                " levels of pages, found more");
}

}  // namespace cairn
