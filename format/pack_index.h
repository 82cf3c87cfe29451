#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/pack_layout.h"
#include "format/index_page.h"

namespace cairn {

/// The index of an open pack. A page is read when something in it is asked for, checked before anything in it
/// is believed, and kept. Any number of threads may call it at once; two that need one page at the same time
/// may both read it.
class PackIndex {
 public:
  /// `rest` is what lies between the header and kPackStartBytes. REQUIRES: the source outlives the index.
  static Result<std::unique_ptr<PackIndex>> open(const ByteSource& source, const PackHeader& header,
                                                 std::span<const std::byte> rest);

  std::span<const PackLevel> levels() const { return levels_; }

  /// An entry, and the number of entries before it.
  struct Found {
    std::size_t ordinal = 0;
    const IndexEntry* entry = nullptr;  ///< valid as long as the index
  };
  /// nullopt where no entry has the key. Errors are those of reading a page.
  Result<std::optional<Found>> find(std::uint64_t key) const;

  /// The entry with so many before it. REQUIRES: ordinal < the header's entry_count.
  Result<const IndexEntry*> at(std::size_t ordinal) const;

  /// Of the page that would hold the entry: what the pages above say of it, however unreadable it is.
  std::uint64_t first_key_near(std::size_t ordinal) const;

  /// Reads and checks every page, and calls `visit` with the place of each but the root's, in the order of
  /// entries, those above before those beneath. Ends at the first error.
  Status read_all(const std::function<void(const ByteRange&)>& visit) const;

 private:
  struct Node;
  PackIndex(const ByteSource& source, const PackHeader& header, PackRoot root);

  Status check_place(const ChildPage& child) const;
  Status check_page(const IndexPage& page, const ChildPage& as_named, std::uint64_t end_key,
                    int height) const;
  Result<std::unique_ptr<Node>> load(const Node& above, std::size_t child,
                                     std::span<const ByteRange> likely_next) const;
  Result<const Node*> child_of(const Node& node, std::size_t child,
                               std::span<const ByteRange> likely_next = {}) const;
  Status read_beneath(const Node& node, const std::function<void(const ByteRange&)>& visit) const;

  const ByteSource& source_;
  const PackHeader& header_;
  std::vector<PackLevel> levels_;
  std::unique_ptr<Node> root_;

 public:
  ~PackIndex();
};

}  // namespace cairn
