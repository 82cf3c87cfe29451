#include "cairn/pack_layout.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "format/bytes.h"
#include "format/checksum.h"

namespace cairn {
namespace {

constexpr std::size_t kHeaderReserved = 3;  // after the datum
constexpr std::size_t kHeaderSpare = 16;    // before the checksum
constexpr std::size_t kHeaderChecksumOffset = kPackHeaderBytes - sizeof(std::uint64_t);

Error field_error(const char* place, const std::string& expected, const std::string& found) {
  return bad_data(std::string(place) + ": expected " + expected + ", found " + found);
}

template <class A, class B>
requires std::is_arithmetic_v<A> Error field_error(const char* place, A expected, B found) {
  return field_error(place, std::to_string(expected), std::to_string(found));
}

bool all_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

/// Magic and version come before the checksum: a newer version may keep its checksum elsewhere.
Status check_identity(std::span<const std::byte> bytes) {
  if (bytes.size() < kPackHeaderBytes) {
    return field_error("header", std::to_string(kPackHeaderBytes) + " bytes", std::to_string(bytes.size()));
  }
  if (!std::equal(kPackMagic.begin(), kPackMagic.end(), reinterpret_cast<const char*>(bytes.data()))) {
    return field_error("header: magic", "a cairn pack's \\x89CAIRN\\r\\n", "other bytes");
  }
  ByteReader in(bytes.subspan(kPackMagic.size()));
  if (const auto version = in.read<std::uint16_t>(); version != kPackVersion) {
    return field_error("header: version", kPackVersion, version);
  }
  ByteReader tail(bytes.subspan(kHeaderChecksumOffset));
  if (tail.read<std::uint64_t>() != checksum(bytes.first(kHeaderChecksumOffset))) {
    return field_error("header: checksum", "that of its bytes", "another");
  }
  return {};
}

Status check_sections(const PackHeader& h) {
  constexpr std::uint64_t kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (h.index_offset < kPackHeaderBytes || h.index_offset > kMost) {
    return field_error("header: index offset", std::to_string(kPackHeaderBytes) + " or more",
                       std::to_string(h.index_offset));
  }
  if (h.index_count > (kMost - h.index_offset) / kIndexEntryBytes) {
    return field_error("header: index count", "one that fits a file", std::to_string(h.index_count));
  }
  if (const auto end = h.index_offset + h.index_count * kIndexEntryBytes; h.metadata_offset != end) {
    return field_error("header: metadata offset", end, h.metadata_offset);
  }
  if (h.metadata_bytes > kMost - h.metadata_offset) {
    return field_error("header: metadata bytes", "a length that fits a file",
                       std::to_string(h.metadata_bytes));
  }
  return {};
}

bool is_tile_size(int size) {
  return size == 513 || size == 257;
}

Status check_block_reference(const IndexEntry& e) {
  const bool absent = e.offset == 0 && e.bytes == 0 && e.checksum == 0;
  if ((e.flags & kConstant) != 0) {
    return absent ? Status()
                  : field_error("constant tile's block", "none", std::to_string(e.bytes) + " bytes");
  }
  if (e.bytes == 0) return field_error("block", "bytes, as the tile is not constant", "none");
  if (e.offset < kPackHeaderBytes) return field_error("block offset", kPackHeaderBytes, e.offset);
  return {};
}

Status check_flags(const IndexEntry& e) {
  if ((e.flags & ~(kConstant | kHasVoids | kHasAlpha)) != 0) {
    return field_error("flags", "bits 0 to 2", std::to_string(e.flags));
  }
  if ((e.flags & kHasVoids) != 0 && (e.layer != Layer::heights || (e.flags & kConstant) != 0)) {
    return field_error("flags", "voids only in a height tile with a block", std::to_string(e.flags));
  }
  if ((e.flags & kHasAlpha) != 0 && e.layer != Layer::imagery) {
    return field_error("flags", "alpha only in imagery", std::to_string(e.flags));
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

const char* to_string(VerticalDatum datum) {
  switch (datum) {
    case VerticalDatum::egm96:
      return "egm96";
    case VerticalDatum::ellipsoid:
      return "ellipsoid";
    case VerticalDatum::unknown:
      break;
  }
  return "unknown";
}

const char* to_string(Layer layer) {
  switch (layer) {
    case Layer::heights:
      return "heights";
    case Layer::imagery:
      return "imagery";
    case Layer::rqt:
      break;
  }
  return "rqt";
}

std::array<std::byte, kPackHeaderBytes> encode_header(const PackHeader& header) {
  std::vector<std::byte> bytes;
  bytes.reserve(kPackHeaderBytes);
  ByteWriter out(bytes);
  out.append(std::as_bytes(std::span(kPackMagic)));
  out.write(header.version);
  out.write(header.tile_size);
  out.write(static_cast<std::uint8_t>(header.vertical_datum));
  bytes.resize(bytes.size() + kHeaderReserved);
  out.write(header.quantum_m);
  out.write(header.index_offset);
  out.write(header.index_count);
  out.write(header.index_checksum);
  out.write(header.metadata_offset);
  out.write(header.metadata_bytes);
  out.write(header.metadata_checksum);
  bytes.resize(bytes.size() + kHeaderSpare);
  out.write(checksum(bytes));
  assert(bytes.size() == kPackHeaderBytes);
  std::array<std::byte, kPackHeaderBytes> result;
  std::copy(bytes.begin(), bytes.end(), result.begin());
  return result;
}

Result<PackHeader> decode_header(std::span<const std::byte> bytes) {
  if (const Status status = check_identity(bytes); !status) return status.error();
  ByteReader in(bytes.first(kHeaderChecksumOffset));
  in.take(kPackMagic.size());
  PackHeader h;
  h.version = in.read<std::uint16_t>();
  h.tile_size = in.read<std::uint16_t>();
  const auto datum = in.read<std::uint8_t>();
  const auto reserved = in.take(kHeaderReserved);
  h.quantum_m = in.read<double>();
  h.index_offset = in.read<std::uint64_t>();
  h.index_count = in.read<std::uint64_t>();
  h.index_checksum = in.read<std::uint64_t>();
  h.metadata_offset = in.read<std::uint64_t>();
  h.metadata_bytes = in.read<std::uint64_t>();
  h.metadata_checksum = in.read<std::uint64_t>();
  const auto spare = in.take(kHeaderSpare);
  assert(in.ok() && in.remaining() == 0);
  if (!is_tile_size(h.tile_size))
    return field_error("header: tile size", "513 or 257", std::to_string(h.tile_size));
  if (datum > 2) return field_error("header: vertical datum", "0 to 2", std::to_string(datum));
  h.vertical_datum = static_cast<VerticalDatum>(datum);
  if (!all_zero(reserved) || !all_zero(spare)) return field_error("header: reserved bytes", "0", "others");
  if (!std::isfinite(h.quantum_m) || h.quantum_m <= 0) {
    return field_error("header: quantum", "a finite length above 0 m", std::to_string(h.quantum_m));
  }
  if (const Status status = check_sections(h); !status) return status.error();
  return h;
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
  assert(bytes.size() == kIndexEntryBytes);
  ByteReader in(bytes);
  IndexEntry e;
  const auto layer = in.read<std::uint8_t>();
  e.layer = static_cast<Layer>(layer);
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
  if (layer > static_cast<std::uint8_t>(Layer::rqt))
    return field_error("layer", "0 to 2", std::to_string(layer));
  if (!is_valid(e.id)) return field_error("tile", "one of the grid", to_string(e.id));
  if (reserved != 0) return field_error("reserved bytes", 0, reserved);
  for (const auto check : {check_flags, check_block_reference, check_values}) {
    if (const Status status = check(e); !status) return status.error();
  }
  return e;
}

}  // namespace cairn
