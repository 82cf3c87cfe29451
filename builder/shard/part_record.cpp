#include "builder/shard/part_record.h"

#include <utility>

#include "format/bytes.h"
#include "format/index_entry.h"

namespace cairn {
namespace {

// A tile that is in no pack yet has no place there. Entries without a place are refused, so it has the first
// one that a block can have.
void append_tile(const TileBlock& tile, std::vector<std::byte>& out) {
  IndexEntry entry = tile.entry;
  entry.offset = tile.block.empty() ? 0 : kPackStartBytes;
  entry.bytes = static_cast<std::uint32_t>(tile.block.size());
  append_entry(entry, out);
  ByteWriter(out).append(tile.block);
}

bool read_tile(ByteReader& in, TileBlock& tile) {
  const auto bytes = in.take(kEntryRecordBytes);
  if (!in.ok()) return false;
  const auto entry = decode_entry(bytes);
  if (!entry) return false;
  tile.entry = *entry;
  const auto block = in.take(entry->bytes);
  tile.block.assign(block.begin(), block.end());
  return in.ok();
}

void append_optional(const std::optional<TileBlock>& tile, std::vector<std::byte>& out) {
  ByteWriter(out).write(std::uint8_t{tile.has_value()});
  if (tile) append_tile(*tile, out);
}

bool read_optional(ByteReader& in, std::optional<TileBlock>& tile) {
  if (in.read<std::uint8_t>() == 0) return in.ok();
  return read_tile(in, tile.emplace());
}

void append_sized(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(static_cast<std::uint64_t>(bytes.size()));
  writer.append(bytes);
}

bool read_sized(ByteReader& in, std::vector<std::byte>& out) {
  const auto bytes = in.take(in.read<std::uint64_t>());
  out.assign(bytes.begin(), bytes.end());
  return in.ok();
}

}  // namespace

std::vector<std::byte> encode_part_record(const PartRecord& record) {
  std::vector<std::byte> out;
  std::size_t bytes = record.root.size() + record.subtree_root.size() + 4 * kEntryRecordBytes;
  for (const TileBlock& tile : record.blocks) bytes += tile.block.size() + kEntryRecordBytes;
  if (record.held) bytes += record.held->block.size();
  if (record.subtree_held) bytes += record.subtree_held->block.size();
  out.reserve(bytes);
  ByteWriter writer(out);
  writer.write(static_cast<std::uint8_t>(record.layer));
  writer.write(std::uint8_t{record.ends_subtree});
  writer.write(std::int32_t{record.unit.level});
  writer.write(record.unit.x);
  writer.write(record.unit.y);
  writer.write(static_cast<std::uint32_t>(record.blocks.size()));
  for (const TileBlock& tile : record.blocks) append_tile(tile, out);
  append_sized(record.root, out);
  append_optional(record.held, out);
  append_sized(record.subtree_root, out);
  append_optional(record.subtree_held, out);
  return out;
}

Result<PartRecord> decode_part_record(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  PartRecord record;
  const auto layer = in.read<std::uint8_t>();
  record.layer = static_cast<Layer>(layer);
  record.ends_subtree = in.read<std::uint8_t>() != 0;
  record.unit.level = in.read<std::int32_t>();
  record.unit.x = in.read<std::int32_t>();
  record.unit.y = in.read<std::int32_t>();
  bool whole = in.ok() && layer < kLayers && is_valid(record.unit);
  for (auto n = in.read<std::uint32_t>(); whole && n > 0; --n)
    whole = read_tile(in, record.blocks.emplace_back());
  whole = whole && read_sized(in, record.root) && read_optional(in, record.held) &&
          read_sized(in, record.subtree_root) && read_optional(in, record.subtree_held);
  if (!whole || in.remaining() != 0)
    return bad_data("a record: expected the tiles of a unit, found other bytes");
  return record;
}

}  // namespace cairn
