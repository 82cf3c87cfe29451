#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

inline constexpr std::size_t kMostPageBytes = 16384;
inline constexpr std::size_t kMostPageRows = 1024;
inline constexpr int kMostPageHeight = 7;

/// A page as the page above it names it.
struct ChildPage {
  std::uint64_t key = 0;      ///< of the first entry beneath it; see format/tile_number.h
  std::uint64_t entries = 0;  ///< beneath it; at least 1
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
  std::uint64_t checksum = 0;

  friend bool operator==(const ChildPage&, const ChildPage&) = default;
};

/// A page of the index, a tree: a leaf, at height 0, has entries, and the others have pages beneath them.
struct IndexPage {
  int height = 0;
  std::vector<std::uint64_t> keys;  ///< strictly ascending; of the entries, or of the first one in each child
  std::vector<IndexEntry> entries;
  std::vector<ChildPage> children;
};

/// The bytes of a page; docs/pack-format.md has the table. The same rows give the same bytes with the same
/// version of zstd. REQUIRES: at most kMostPageRows rows, in strictly ascending order of their keys.
std::vector<std::byte> encode_leaf_page(std::span<const IndexEntry> entries);
std::vector<std::byte> encode_branch_page(int height, std::span<const ChildPage> children);

/// bad_data where the bytes are no such page: too many rows, a field out of range, rows out of order, bytes
/// left over. Whether offsets lie in the file is for the caller to check.
Result<IndexPage> decode_index_page(std::span<const std::byte> bytes);

/// What follows the header: what the pack holds of each level, and the page that all others hang from.
struct PackRoot {
  std::vector<PackLevel> levels;  ///< strictly ascending by layer, then level
  IndexPage page;
};

/// REQUIRES: `page` is an encoded page.
std::vector<std::byte> encode_root(std::span<const PackLevel> levels, std::span<const std::byte> page);
Result<PackRoot> decode_root(std::span<const std::byte> bytes);

}  // namespace cairn
