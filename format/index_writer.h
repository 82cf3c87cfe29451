#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"
#include "format/index_page.h"

namespace cairn {

/// Writes the pages of an index, leaves first. What it keeps in memory is 40 bytes for each page.
class IndexWriter {
 public:
  /// Puts a page at the end of the file and returns where that was.
  using Append = std::function<Result<std::uint64_t>(std::span<const std::byte>)>;

  /// `levels` goes into the root.
  IndexWriter(std::vector<PackLevel> levels, Append append)
      : levels_(std::move(levels)), append_(std::move(append)) {}

  /// REQUIRES: keys ascend strictly.
  Status add(const IndexEntry& entry);

  /// Writes what is left and returns the root, which is small enough to follow the header.
  Result<std::vector<std::byte>> finish();

 private:
  template <class Row, class Encode>
  Result<ChildPage> write_page(std::span<const Row> rows, std::size_t& taken, const Encode& encode);
  Status write_leaf();
  Status write_branches(int height);

  std::vector<PackLevel> levels_;
  Append append_;
  std::vector<IndexEntry> pending_;
  std::vector<ChildPage> pages_;  // of the height that is under way
};

}  // namespace cairn
