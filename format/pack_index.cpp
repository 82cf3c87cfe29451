#include "format/pack_index.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>

#include "format/checked_read.h"
#include "format/checksum.h"
#include "format/tile_number.h"

namespace cairn {

namespace {

constexpr std::uint64_t kNoKey = std::numeric_limits<std::uint64_t>::max();  // above every key

std::string place_of(const ChildPage& child) {
  return "index page at byte " + std::to_string(child.offset);
}

Error expected(const std::string& wanted, const std::string& found) {
  return bad_data("expected " + wanted + ", found " + found);
}

std::uint64_t entries_of(const IndexPage& page) {
  std::uint64_t all = page.entries.size();
  for (const ChildPage& child : page.children) all += child.entries;
  return all;
}

}  // namespace

struct PackIndex::Node {
  Node(IndexPage content, std::uint64_t first_ordinal, std::uint64_t last_key)
      : page(std::move(content)),
        first(first_ordinal),
        end_key(last_key),
        loaded(new std::atomic<const Node*>[page.children.size()]()) {
    std::uint64_t at = first;
    for (const ChildPage& child : page.children) {
      before.push_back(at);
      at += child.entries;
    }
  }
  ~Node() {
    for (std::size_t i = 0; i < page.children.size(); ++i) delete loaded[i].load();
  }

  std::uint64_t end_key_of(std::size_t child) const {
    return child + 1 < page.keys.size() ? page.keys[child + 1] : end_key;
  }

  IndexPage page;
  std::uint64_t first;    // ordinal of its first entry
  std::uint64_t end_key;  // all keys beneath are below it
  std::vector<std::uint64_t> before;
  std::unique_ptr<std::atomic<const Node*>[]> loaded;
};

PackIndex::PackIndex(const ByteSource& source, const PackHeader& header, PackRoot root)
    : source_(source),
      header_(header),
      levels_(std::move(root.levels)),
      root_(new Node(std::move(root.page), 0, kNoKey)) {}

PackIndex::~PackIndex() = default;

Result<std::unique_ptr<PackIndex>> PackIndex::open(const ByteSource& source, const PackHeader& header,
                                                   std::span<const std::byte> rest) {
  if (checksum(rest) != header.root_checksum)
    return in_file(source, "root", bad_data("checksum: expected the header's, found another"));
  auto root = decode_root(rest.first(header.root_bytes));
  if (!root) return in_file(source, "root", root.error());
  std::uint64_t tiles = 0;
  for (const PackLevel& level : root->levels) tiles += level.tiles;
  const std::uint64_t beneath = entries_of(root->page);
  if (tiles != header.entry_count || beneath != header.entry_count) {
    return in_file(source, "root",
                   expected(std::to_string(header.entry_count) + " entries as the header has",
                            std::to_string(beneath) + ", and " + std::to_string(tiles) + " by level"));
  }
  std::unique_ptr<PackIndex> index(new PackIndex(source, header, std::move(*root)));
  const IndexPage& page = index->root_->page;
  const ChildPage whole{page.keys.empty() ? 0 : page.keys.front(), beneath, 0, 0, 0};
  if (const Status status = index->check_page(page, whole, kNoKey, page.height); !status)
    return in_file(source, "root", status.error());
  return index;
}

Status PackIndex::check_place(const ChildPage& child) const {
  if (child.offset >= header_.index_offset && child.offset <= header_.metadata_offset &&
      child.bytes <= header_.metadata_offset - child.offset)
    return {};
  return expected("pages between bytes " + std::to_string(header_.index_offset) + " and " +
                      std::to_string(header_.metadata_offset),
                  std::to_string(child.bytes) + " bytes at " + std::to_string(child.offset));
}

// What the pages above do not say of it is checked when it is decoded.
Status PackIndex::check_page(const IndexPage& page, const ChildPage& as_named, std::uint64_t end_key,
                             int height) const {
  if (page.height != height)
    return expected("a page of height " + std::to_string(height), std::to_string(page.height));
  if (entries_of(page) != as_named.entries)
    return expected(std::to_string(as_named.entries) + " entries", std::to_string(entries_of(page)));
  if (!page.keys.empty() && (page.keys.front() != as_named.key || page.keys.back() >= end_key))
    return expected("keys from " + std::to_string(as_named.key) + " to below " + std::to_string(end_key),
                    std::to_string(page.keys.front()) + " to " + std::to_string(page.keys.back()));
  for (const ChildPage& child : page.children) {
    if (Status status = check_place(child); !status) return status;
  }
  for (const IndexEntry& entry : page.entries) {
    if (entry.bytes == 0 ||
        (entry.offset <= header_.index_offset && entry.bytes <= header_.index_offset - entry.offset))
      continue;
    return bad_data(std::string(to_string(entry.layer)) + " tile " + to_string(entry.id) +
                    ": expected a block before byte " + std::to_string(header_.index_offset) + ", found " +
                    std::to_string(entry.bytes) + " bytes at " + std::to_string(entry.offset));
  }
  return {};
}

Result<std::unique_ptr<PackIndex::Node>> PackIndex::load(const Node& above, std::size_t child,
                                                         std::span<const ByteRange> likely_next) const {
  const ChildPage& named = above.page.children[child];
  const auto bytes =
      read_checked(source_, {{named.offset, named.bytes}, named.checksum}, place_of(named), likely_next);
  if (!bytes) return bytes.error();
  auto page = decode_index_page(*bytes);
  if (!page) return in_file(source_, place_of(named), page.error());
  const std::uint64_t end_key = above.end_key_of(child);
  if (const Status status = check_page(*page, named, end_key, above.page.height - 1); !status)
    return in_file(source_, place_of(named), status.error());
  return std::make_unique<Node>(std::move(*page), above.before[child], end_key);
}

Result<const PackIndex::Node*> PackIndex::child_of(const Node& node, std::size_t child,
                                                   std::span<const ByteRange> likely_next) const {
  std::atomic<const Node*>& slot = node.loaded[child];
  if (const Node* there = slot.load(std::memory_order_acquire)) return there;
  auto fresh = load(node, child, likely_next);
  if (!fresh) return fresh.error();
  const Node* expected_none = nullptr;
  if (!slot.compare_exchange_strong(expected_none, fresh->get(), std::memory_order_acq_rel))
    return expected_none;  // another thread was quicker
  return static_cast<const Node*>(fresh->release());
}

Result<std::optional<PackIndex::Found>> PackIndex::find(std::uint64_t key) const {
  for (const Node* node = root_.get();;) {
    const std::vector<std::uint64_t>& keys = node->page.keys;
    const auto after = std::upper_bound(keys.begin(), keys.end(), key);
    if (after == keys.begin()) return std::optional<Found>();
    const auto at = static_cast<std::size_t>(after - keys.begin()) - 1;
    if (node->page.height == 0) {
      if (keys[at] != key) return std::optional<Found>();
      return std::optional(Found{static_cast<std::size_t>(node->first) + at, &node->page.entries[at]});
    }
    const auto child = child_of(*node, at);
    if (!child) return child.error();
    node = *child;
  }
}

Result<const IndexEntry*> PackIndex::at(std::size_t ordinal) const {
  assert(ordinal < header_.entry_count);
  const Node* node = root_.get();
  while (node->page.height > 0) {
    const auto after = std::upper_bound(node->before.begin(), node->before.end(), ordinal);
    const auto child = child_of(*node, static_cast<std::size_t>(after - node->before.begin()) - 1);
    if (!child) return child.error();
    node = *child;
  }
  return &node->page.entries[ordinal - node->first];
}

std::uint64_t PackIndex::first_key_near(std::size_t ordinal) const {
  const Node* node = root_.get();
  while (node->page.height > 0) {
    const auto after = std::upper_bound(node->before.begin(), node->before.end(), ordinal);
    const auto at = static_cast<std::size_t>(after - node->before.begin()) - 1;
    const Node* child = node->loaded[at].load(std::memory_order_acquire);
    if (child == nullptr) return node->page.keys[at];
    node = child;
  }
  return node->page.keys[ordinal - node->first];
}

Status PackIndex::read_beneath(const Node& node, const std::function<void(const ByteRange&)>& visit) const {
  std::vector<ByteRange> pages;
  for (const ChildPage& child : node.page.children) pages.push_back({child.offset, child.bytes});
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const auto child = child_of(node, i, std::span(pages).subspan(i + 1));
    if (!child) return child.error();
    visit(pages[i]);
    if (Status status = read_beneath(**child, visit); !status) return status;
  }
  return {};
}

Status PackIndex::read_all(const std::function<void(const ByteRange&)>& visit) const {
  return read_beneath(*root_, visit);
}

}  // namespace cairn
