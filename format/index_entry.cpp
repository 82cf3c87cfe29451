#include "format/index_entry.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <type_traits>

#include "format/bytes.h"

namespace cairn {
namespace {

Error field_error(const char* place, const std::string& expected, const std::string& found) {
  return bad_data(std::string(place) + ": expected " + expected + ", found " + found);
}

template <class A, class B>
requires std::is_arithmetic_v<A> Error field_error(const char* place, A expected, B found) {
  return field_error(place, std::to_string(expected), std::to_string(found));
}

Status check_place(const IndexEntry& e) {
  if (static_cast<std::size_t>(e.layer) >= kLayers)
    return field_error("layer", kLayers - 1, static_cast<int>(e.layer));
  if (!is_valid(e.id)) return field_error("tile", "one of the grid", to_string(e.id));
  return {};
}

Status check_block_reference(const IndexEntry& e) {
  const bool absent = e.offset == 0 && e.bytes == 0 && e.checksum == 0;
  if ((e.flags & kConstant) != 0) {
    return absent ? Status()
                  : field_error("constant tile's block", "none", std::to_string(e.bytes) + " bytes");
  }
  if (e.bytes == 0) return field_error("block", "bytes, as the tile is not constant", "none");
  if (e.offset < kPackStartBytes) return field_error("block offset", kPackStartBytes, e.offset);
  return {};
}

Status check_flags(const IndexEntry& e) {
  if ((e.flags & ~(kConstant | kHasVoids | kHasAlpha | kSharedBlock)) != 0) {
    return field_error("flags", "bits 0 to 3", std::to_string(e.flags));
  }
  if ((e.flags & kHasVoids) != 0 && (e.layer != Layer::heights || (e.flags & kConstant) != 0)) {
    return field_error("flags", "voids only in a height tile with a block", std::to_string(e.flags));
  }
  if ((e.flags & kHasAlpha) != 0 && e.layer != Layer::imagery) {
    return field_error("flags", "alpha only in imagery", std::to_string(e.flags));
  }
  if ((e.flags & kSharedBlock) != 0 && (e.flags & kConstant) != 0) {
    return field_error("flags", "a shared block only where there is one", std::to_string(e.flags));
  }
  return {};
}

Status check_values(const IndexEntry& e) {
  if (!std::isfinite(e.geometric_error_m) || e.geometric_error_m < 0) {
    return field_error("geometric error", "a finite length, 0 m or more",
                       std::to_string(e.geometric_error_m));
  }
  if (e.layer != Layer::heights) return {};
  if (e.min_quanta > e.max_quanta)
    return field_error("minimum", "at most the maximum", std::to_string(e.min_quanta));
  if ((e.flags & kConstant) != 0 && e.min_quanta != e.max_quanta) {
    return field_error("constant tile's maximum", e.min_quanta, e.max_quanta);
  }
  return {};
}

}  // namespace

Status check_entry(const IndexEntry& entry) {
  for (const auto check : {check_place, check_flags, check_block_reference, check_values}) {
    if (Status status = check(entry); !status) return status;
  }
  return {};
}

void add_to_level(const IndexEntry& entry, PackLevel& level) {
  level.max_error_m = std::max(level.max_error_m, entry.geometric_error_m);
  ++level.tiles;
  if ((entry.flags & kConstant) != 0) ++level.constant_tiles;
  if ((entry.flags & kSharedBlock) == 0) level.block_bytes += entry.bytes;
}

void append_entry(const IndexEntry& entry, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(static_cast<std::uint8_t>(entry.layer));
  writer.write(static_cast<std::int8_t>(entry.id.level));
  writer.write(entry.flags);
  writer.write(entry.id.x);
  writer.write(entry.id.y);
  writer.write(entry.bytes);
  writer.write(entry.offset);
  writer.write(entry.checksum);
  writer.write(entry.min_quanta);
  writer.write(entry.max_quanta);
  writer.write(entry.geometric_error_m);
  writer.write(entry.filled);
  writer.write(std::uint16_t{0});
}

Result<IndexEntry> decode_entry(std::span<const std::byte> bytes) {
  assert(bytes.size() == kEntryRecordBytes);
  ByteReader in(bytes);
  IndexEntry e;
  e.layer = static_cast<Layer>(in.read<std::uint8_t>());
  e.id.level = in.read<std::int8_t>();
  e.flags = in.read<std::uint16_t>();
  e.id.x = in.read<std::int32_t>();
  e.id.y = in.read<std::int32_t>();
  e.bytes = in.read<std::uint32_t>();
  e.offset = in.read<std::uint64_t>();
  e.checksum = in.read<std::uint64_t>();
  e.min_quanta = in.read<std::int32_t>();
  e.max_quanta = in.read<std::int32_t>();
  e.geometric_error_m = in.read<float>();
  e.filled = in.read<std::uint16_t>();
  const auto reserved = in.read<std::uint16_t>();
  if (reserved != 0) return field_error("reserved bytes", 0, reserved);
  if (const Status status = check_entry(e); !status) return status.error();
  return e;
}

}  // namespace cairn
