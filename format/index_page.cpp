#include "format/index_page.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include "format/bytes.h"
#include "format/column_codec.h"
#include "format/index_entry.h"
#include "format/tile_number.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

constexpr int kZstdLevel = 9;  // pages are small; the level decides bytes, so it never changes

Error page_error(const std::string& expected, const std::string& found) {
  return bad_data("expected " + expected + ", found " + found);
}

// --- A page around its columns and checksums. ---

std::vector<std::byte> encode_page(int height, std::size_t rows, const ColumnWriter& columns,
                                   std::span<const std::uint64_t> checksums) {
  std::vector<std::byte> frame;
  append_zstd_frame(columns.bytes(), {.level = kZstdLevel}, frame);
  assert(rows <= kMostPageRows && columns.bytes().size() <= UINT16_MAX);
  std::vector<std::byte> page;
  ByteWriter out(page);
  out.write(static_cast<std::uint8_t>(height));
  out.write(std::uint8_t{0});
  out.write(static_cast<std::uint16_t>(rows));
  out.write(static_cast<std::uint16_t>(frame.size()));
  out.write(static_cast<std::uint16_t>(columns.bytes().size()));
  out.append(frame);
  for (const std::uint64_t sum : checksums) out.write(sum);
  return page;
}

std::uint64_t next_key(ColumnReader& in, const std::vector<std::uint64_t>& keys, Status& status) {
  const std::uint64_t step = in.number();
  const std::uint64_t before = keys.empty() ? 0 : keys.back();
  if (!keys.empty() && (step == 0 || step > std::numeric_limits<std::uint64_t>::max() - before))
    status = page_error("keys that ascend", "row " + std::to_string(keys.size()) + " after another");
  return before + step;
}

Status decode_keys(ColumnReader& in, std::size_t rows, IndexPage& page) {
  Status status;
  for (std::size_t i = 0; i < rows; ++i) page.keys.push_back(next_key(in, page.keys, status));
  return status;
}

bool has_block(const IndexEntry& entry) {
  return (entry.flags & kConstant) == 0;
}

Status decode_entries(ColumnReader& in, ByteReader& sums, IndexPage& page) {
  std::vector<IndexEntry>& entries = page.entries;
  entries.resize(page.keys.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto tile = tile_of_key(page.keys[i]);
    if (!tile) return page_error("tiles of the grid", "key " + std::to_string(page.keys[i]));
    entries[i].layer = tile->layer;
    entries[i].id = tile->id;
  }
  for (IndexEntry& e : entries) e.flags = in.number_of<std::uint16_t>();
  for (IndexEntry& e : entries) {
    if (has_block(e)) e.bytes = in.number_of<std::uint32_t>();
  }
  std::uint64_t end = 0;
  for (IndexEntry& e : entries) {
    if (!has_block(e)) continue;
    e.offset = in.near(end);
    end = e.offset + e.bytes;
  }
  std::int32_t lowest = 0;
  for (IndexEntry& e : entries) lowest = e.min_quanta = in.near(lowest);
  for (IndexEntry& e : entries) e.max_quanta = in.near(e.min_quanta);
  for (IndexEntry& e : entries) e.geometric_error_m = std::bit_cast<float>(in.word());
  for (IndexEntry& e : entries) e.filled = in.number_of<std::uint16_t>();
  for (IndexEntry& e : entries) {
    if (has_block(e)) e.checksum = sums.read<std::uint64_t>();
  }
  if (!in.ok() || !sums.ok()) return {};  // the caller says so
  for (const IndexEntry& e : entries) {
    if (const Status status = check_entry(e); !status)
      return bad_data(std::string(to_string(e.layer)) + " tile " + to_string(e.id) + ": " +
                      status.error().message);
  }
  return {};
}

Status decode_children(ColumnReader& in, ByteReader& sums, IndexPage& page) {
  std::vector<ChildPage>& children = page.children;
  children.resize(page.keys.size());
  for (std::size_t i = 0; i < children.size(); ++i) children[i].key = page.keys[i];
  std::uint64_t all = 0;
  for (ChildPage& c : children) {
    c.entries = in.number();
    if (in.ok() && (c.entries == 0 || c.entries > std::numeric_limits<std::int64_t>::max() - all))
      return page_error("entries beneath each page", std::to_string(c.entries));
    all += c.entries;
  }
  for (ChildPage& c : children) {
    c.bytes = in.number_of<std::uint32_t>();
    if (in.ok() && (c.bytes == 0 || c.bytes > kMostPageBytes))
      return page_error("pages of 1 to " + std::to_string(kMostPageBytes) + " bytes",
                        std::to_string(c.bytes));
  }
  std::uint64_t end = 0;
  for (ChildPage& c : children) {
    c.offset = in.near(end);
    end = c.offset + c.bytes;
  }
  for (ChildPage& c : children) c.checksum = sums.read<std::uint64_t>();
  return {};
}

}  // namespace

std::vector<std::byte> encode_leaf_page(std::span<const IndexEntry> entries) {
  ColumnWriter out;
  std::vector<std::uint64_t> checksums;
  std::uint64_t key = 0;
  for (const IndexEntry& e : entries) {
    out.number(index_key_of(e) - key);
    key = index_key_of(e);
  }
  for (const IndexEntry& e : entries) out.number(e.flags);
  for (const IndexEntry& e : entries) {
    if (has_block(e)) out.number(e.bytes);
  }
  std::uint64_t end = 0;
  for (const IndexEntry& e : entries) {
    if (!has_block(e)) continue;
    out.difference(static_cast<std::int64_t>(e.offset - end));
    end = e.offset + e.bytes;
    checksums.push_back(e.checksum);
  }
  std::int64_t lowest = 0;
  for (const IndexEntry& e : entries) {
    out.difference(e.min_quanta - lowest);
    lowest = e.min_quanta;
  }
  for (const IndexEntry& e : entries) out.difference(std::int64_t{e.max_quanta} - e.min_quanta);
  for (const IndexEntry& e : entries) out.word(std::bit_cast<std::uint32_t>(e.geometric_error_m));
  for (const IndexEntry& e : entries) out.number(e.filled);
  return encode_page(0, entries.size(), out, checksums);
}

std::vector<std::byte> encode_branch_page(int height, std::span<const ChildPage> children) {
  assert(height >= 1 && height <= kMostPageHeight);
  ColumnWriter out;
  std::vector<std::uint64_t> checksums;
  std::uint64_t key = 0;
  for (const ChildPage& c : children) {
    out.number(c.key - key);
    key = c.key;
  }
  for (const ChildPage& c : children) out.number(c.entries);
  for (const ChildPage& c : children) out.number(c.bytes);
  std::uint64_t end = 0;
  for (const ChildPage& c : children) {
    out.difference(static_cast<std::int64_t>(c.offset - end));
    end = c.offset + c.bytes;
    checksums.push_back(c.checksum);
  }
  return encode_page(height, children.size(), out, checksums);
}

Result<IndexPage> decode_index_page(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const auto height = in.read<std::uint8_t>();
  const auto reserved = in.read<std::uint8_t>();
  const std::size_t rows = in.read<std::uint16_t>();
  const auto frame_bytes = in.read<std::uint16_t>();
  const auto column_bytes = in.read<std::uint16_t>();
  const auto frame = in.take(frame_bytes);
  if (!in.ok()) return page_error("a whole page", std::to_string(bytes.size()) + " bytes");
  if (reserved != 0) return page_error("0 in the reserved byte", std::to_string(reserved));
  if (height > kMostPageHeight)
    return page_error("height 0 to " + std::to_string(kMostPageHeight), std::to_string(height));
  if (rows > kMostPageRows)
    return page_error("at most " + std::to_string(kMostPageRows) + " rows", std::to_string(rows));
  std::vector<std::byte> content(column_bytes);
  if (const Status status = decode_zstd_frame(frame, content); !status) return status.error();
  IndexPage page;
  page.height = height;
  ColumnReader columns(content);
  Status status = decode_keys(columns, rows, page);
  if (status) status = height == 0 ? decode_entries(columns, in, page) : decode_children(columns, in, page);
  if (!status) return status.error();
  if (!columns.finished()) return page_error("columns of " + std::to_string(rows) + " rows", "others");
  if (!in.ok() || in.remaining() != 0)
    return page_error("a checksum for each block or page", "more bytes or fewer");
  return page;
}

std::vector<std::byte> encode_root(std::span<const PackLevel> levels, std::span<const std::byte> page) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  out.write(static_cast<std::uint32_t>(levels.size()));
  for (const PackLevel& level : levels) {
    out.write(static_cast<std::uint8_t>(level.layer));
    out.write(static_cast<std::int8_t>(level.level));
    out.write(std::uint16_t{0});
    out.write(level.max_error_m);
    out.write(level.tiles);
    out.write(level.constant_tiles);
    out.write(level.block_bytes);
  }
  out.append(page);
  return bytes;
}

namespace {

Result<PackLevel> decode_level(ByteReader& in) {
  PackLevel level;
  const auto layer = in.read<std::uint8_t>();
  level.layer = static_cast<Layer>(layer);
  level.level = in.read<std::int8_t>();
  const auto reserved = in.read<std::uint16_t>();
  level.max_error_m = in.read<float>();
  level.tiles = in.read<std::uint64_t>();
  level.constant_tiles = in.read<std::uint64_t>();
  level.block_bytes = in.read<std::uint64_t>();
  if (!in.ok()) return page_error("a whole table of levels", "fewer bytes");
  if (layer >= kLayers || level.level < kMinLevel || level.level > kMaxLevel || reserved != 0)
    return page_error("a level of a layer",
                      "layer " + std::to_string(layer) + " level " + std::to_string(level.level));
  if (!std::isfinite(level.max_error_m) || level.max_error_m < 0 || level.tiles == 0 ||
      level.constant_tiles > level.tiles)
    return page_error("tiles and errors of level " + std::to_string(level.level), "numbers out of range");
  return level;
}

}  // namespace

Result<PackRoot> decode_root(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  PackRoot root;
  const auto rows = in.read<std::uint32_t>();
  const auto order = [](const PackLevel& l) { return static_cast<int>(l.layer) * 64 + l.level; };
  for (std::uint32_t i = 0; i < rows; ++i) {
    const auto level = decode_level(in);
    if (!level) return level.error();
    if (i > 0 && order(*level) <= order(root.levels.back()))
      return page_error("levels that ascend", "level " + std::to_string(level->level) + " after another");
    root.levels.push_back(*level);
  }
  auto page = decode_index_page(in.take(in.remaining()));
  if (!page) return page.error();
  root.page = std::move(*page);
  return root;
}

}  // namespace cairn
