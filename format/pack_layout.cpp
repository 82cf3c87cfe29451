#include "cairn/pack_layout.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "format/bytes.h"
#include "format/checksum.h"

namespace cairn {
namespace {

constexpr std::size_t kBodyNameBytes = 32;
constexpr std::size_t kDatumNameBytes = 40;
constexpr std::size_t kSpareBytes = 56;
constexpr std::size_t kIdOffset = 224;
constexpr std::size_t kHeaderChecksumOffset = kPackHeaderBytes - sizeof(std::uint64_t);

Error field_error(const char* place, const std::string& expected, const std::string& found) {
  return bad_data("header: " + std::string(place) + ": expected " + expected + ", found " + found);
}

template <class A, class B>
requires std::is_arithmetic_v<A> Error field_error(const char* place, A expected, B found) {
  return field_error(place, std::to_string(expected), std::to_string(found));
}

bool all_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

/// A text in a field of fixed size, which ends with one zero or more.
void append_text(std::string_view text, std::size_t field_bytes, std::vector<std::byte>& out) {
  assert(text.size() < field_bytes);
  const std::size_t start = out.size();
  out.resize(start + field_bytes);
  std::transform(text.begin(), text.end(), out.begin() + static_cast<std::ptrdiff_t>(start),
                 [](char c) { return static_cast<std::byte>(c); });
}

std::optional<std::string> text_of(std::span<const std::byte> field) {
  const auto end = std::find(field.begin(), field.end(), std::byte{0});
  const auto length = static_cast<std::size_t>(end - field.begin());
  if (length == 0 || length == field.size() || !all_zero(field.subspan(length))) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(field.data()), length);
}

/// Magic and version come before the checksum: a newer version may keep its checksum elsewhere.
Status check_identity(std::span<const std::byte> bytes) {
  if (bytes.size() < kPackHeaderBytes) {
    return bad_data("header: expected " + std::to_string(kPackHeaderBytes) + " bytes, found " +
                    std::to_string(bytes.size()));
  }
  if (!std::equal(kPackMagic.begin(), kPackMagic.end(), reinterpret_cast<const char*>(bytes.data()))) {
    return field_error("magic", "a cairn pack's \\x89CAIRN\\r\\n", "other bytes");
  }
  ByteReader in(bytes.subspan(kPackMagic.size()));
  if (const auto version = in.read<std::uint16_t>(); version != kPackVersion) {
    return field_error("version", kPackVersion, version);
  }
  ByteReader tail(bytes.subspan(kHeaderChecksumOffset));
  if (tail.read<std::uint64_t>() != checksum(bytes.first(kHeaderChecksumOffset))) {
    return field_error("checksum", "that of its bytes", "another");
  }
  return {};
}

Status check_sections(const PackHeader& h) {
  constexpr std::uint64_t kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (h.index_offset < kPackStartBytes || h.index_offset > kMost) {
    return field_error("index offset", std::to_string(kPackStartBytes) + " or more",
                       std::to_string(h.index_offset));
  }
  if (h.metadata_offset < h.index_offset || h.metadata_offset > kMost) {
    return field_error("metadata offset", std::to_string(h.index_offset) + " or more",
                       std::to_string(h.metadata_offset));
  }
  if (h.metadata_bytes > kMost - h.metadata_offset) {
    return field_error("metadata bytes", "a length that fits a file", std::to_string(h.metadata_bytes));
  }
  if (h.root_bytes > kPackStartBytes - kPackHeaderBytes) {
    return field_error("root bytes", std::to_string(kPackStartBytes - kPackHeaderBytes) + " or fewer",
                       std::to_string(h.root_bytes));
  }
  return {};
}

Status check_fields(const PackHeader& h) {
  if (h.tile_size != 513 && h.tile_size != 257)
    return field_error("tile size", "513 or 257", std::to_string(h.tile_size));
  if (!std::isfinite(h.quantum_m) || h.quantum_m <= 0) {
    return field_error("quantum", "a finite length above 0 m", std::to_string(h.quantum_m));
  }
  const Ellipsoid& body = h.body.shape;
  if (!std::isfinite(body.semi_major_m) || !(body.semi_minor_m > 0) ||
      body.semi_minor_m > body.semi_major_m) {
    return field_error("semi-axes", "finite lengths, 0 < minor <= major",
                       std::to_string(body.semi_major_m) + " and " + std::to_string(body.semi_minor_m));
  }
  return check_sections(h);
}

void set_datum(const std::string& name, PackHeader& header) {
  for (const auto datum : {VerticalDatum::unknown, VerticalDatum::egm96, VerticalDatum::ellipsoid}) {
    if (name != to_string(datum)) continue;
    header.vertical_datum = datum;
    return;
  }
  header.other_datum = name;
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
      return "rqt";
    case Layer::objects:
      return "objects";
    case Layer::water:
      return "water";
    case Layer::models:
      break;
  }
  return "models";
}

std::string to_string(const PackId& id) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::byte b : id) {
    text += digits[std::to_integer<unsigned>(b) >> 4];
    text += digits[std::to_integer<unsigned>(b) & 15];
  }
  return text;
}

std::array<std::byte, kPackHeaderBytes> encode_header(const PackHeader& header) {
  std::vector<std::byte> bytes;
  bytes.reserve(kPackHeaderBytes);
  ByteWriter out(bytes);
  out.append(std::as_bytes(std::span(kPackMagic)));
  out.write(header.version);
  out.write(header.tile_size);
  out.write(std::uint32_t{0});
  out.write(header.quantum_m);
  append_text(header.body.name, kBodyNameBytes, bytes);
  out.write(header.body.shape.semi_major_m);
  out.write(header.body.shape.semi_minor_m);
  append_text(header.datum_name(), kDatumNameBytes, bytes);
  out.write(header.entry_count);
  out.write(header.index_offset);
  out.write(header.metadata_offset);
  out.write(header.metadata_bytes);
  out.write(header.metadata_checksum);
  out.write(header.root_bytes);
  out.write(std::uint32_t{0});
  out.write(header.root_checksum);
  bytes.resize(bytes.size() + kSpareBytes);
  assert(bytes.size() == kIdOffset);
  out.append(long_checksum(bytes));
  out.write(std::uint64_t{0});
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
  const auto first_reserved = in.read<std::uint32_t>();
  h.quantum_m = in.read<double>();
  const auto body_name = text_of(in.take(kBodyNameBytes));
  h.body.shape.semi_major_m = in.read<double>();
  h.body.shape.semi_minor_m = in.read<double>();
  const auto datum = text_of(in.take(kDatumNameBytes));
  h.entry_count = in.read<std::uint64_t>();
  h.index_offset = in.read<std::uint64_t>();
  h.metadata_offset = in.read<std::uint64_t>();
  h.metadata_bytes = in.read<std::uint64_t>();
  h.metadata_checksum = in.read<std::uint64_t>();
  h.root_bytes = in.read<std::uint32_t>();
  const auto second_reserved = in.read<std::uint32_t>();
  h.root_checksum = in.read<std::uint64_t>();
  const auto spare = in.take(kSpareBytes);
  const auto id = in.take(h.id.size());
  const auto last_reserved = in.read<std::uint64_t>();
  assert(in.ok() && in.remaining() == 0);
  if (first_reserved != 0 || second_reserved != 0 || last_reserved != 0 || !all_zero(spare))
    return field_error("reserved bytes", "0", "others");
  if (!body_name) return field_error("body", "a name that ends with zeros", "none");
  if (!datum) return field_error("vertical datum", "a name that ends with zeros", "none");
  h.body.name = *body_name;
  set_datum(*datum, h);
  std::copy(id.begin(), id.end(), h.id.begin());
  if (h.id != long_checksum(bytes.first(kIdOffset)))
    return field_error("pack id", "that of the bytes before it", "another");
  if (const Status status = check_fields(h); !status) return status.error();
  return h;
}

}  // namespace cairn
