#include "cairn/pack_layout.h"

#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

#include "format/checksum.h"

namespace cairn {
namespace {

PackHeader some_header() {
  PackHeader header;
  header.vertical_datum = VerticalDatum::ellipsoid;
  header.quantum_m = 0.1;
  header.index_offset = 1000;
  header.index_count = 7;
  header.index_checksum = 0x0123456789ABCDEF;
  header.metadata_offset = 1000 + 7 * kIndexEntryBytes;
  header.metadata_bytes = 55;
  header.metadata_checksum = 99;
  return header;
}

IndexEntry some_entry() {
  IndexEntry entry;
  entry.flags = kHasVoids;
  entry.id = {-3, 44, 20};
  entry.offset = 1u << 20;
  entry.bytes = 77;
  entry.checksum = 5;
  entry.min_quanta = -400;
  entry.max_quanta = 35000;
  entry.geometric_error_m = 12.5f;
  entry.filled = 65535;
  return entry;
}

bool refused(const IndexEntry& entry) {
  std::vector<std::byte> bytes;
  append_entry(entry, bytes);
  const auto result = decode_entry(bytes);
  return !result.ok() && result.error().code == ErrorCode::bad_data;
}

/// Encodes the header, applies `change` to its bytes, and puts a right checksum under the result.
template <class Change>
Result<PackHeader> decode_changed(const PackHeader& header, Change change) {
  auto bytes = encode_header(header);
  change(bytes);
  const std::uint64_t sum = checksum(std::span(bytes).first(88));
  std::memcpy(bytes.data() + 88, &sum, 8);
  return decode_header(bytes);
}

}  // namespace

TEST_CASE("a pack's header comes back as it was written") {
  const PackHeader header = some_header();
  const auto bytes = encode_header(header);
  const auto back = decode_header(bytes);
  REQUIRE(back.ok());
  CHECK(encode_header(*back) == bytes);
  CHECK(back->quantum_m == 0.1);
  CHECK(back->vertical_datum == VerticalDatum::ellipsoid);
  CHECK(back->file_bytes() == header.metadata_offset + 55);
}

TEST_CASE("every prefix and every flipped bit of a header is refused") {
  const auto bytes = encode_header(some_header());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    CHECK_FALSE(decode_header(std::span(bytes).first(length)).ok());
  }
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto flipped = bytes;
    flipped[bit / 8] ^= std::byte{1} << (bit % 8);
    CHECK_FALSE(decode_header(flipped).ok());
  }
}

TEST_CASE("a header with a right checksum and an impossible field is refused, and the field is named") {
  const auto says = [](const Result<PackHeader>& result, const char* field) {
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().code == ErrorCode::bad_data);
    CHECK_THAT(result.error().message, Catch::Contains(field));
  };
  const auto nothing = [](auto&) {};
  PackHeader h = some_header();
  CHECK(decode_changed(h, nothing).ok());
  says(decode_changed(h, [](auto& b) { b[8] = std::byte{2}; }), "version");
  says(decode_changed(h, [](auto& b) { b[10] = std::byte{2}; }), "tile size");
  says(decode_changed(h, [](auto& b) { b[12] = std::byte{3}; }), "datum");
  for (const std::size_t at : {13u, 14u, 15u, 72u, 80u, 87u}) {
    says(decode_changed(h, [at](auto& b) { b[at] = std::byte{1}; }), "reserved");
  }
  for (const double quantum : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    h = some_header();
    h.quantum_m = quantum;
    says(decode_changed(h, nothing), "quantum");
  }
  h = some_header();
  h.index_offset = 95;
  says(decode_changed(h, nothing), "index offset");
  h = some_header();
  h.index_count = std::numeric_limits<std::uint64_t>::max() / kIndexEntryBytes;
  says(decode_changed(h, nothing), "index count");
  h = some_header();
  h.metadata_offset += 1;
  says(decode_changed(h, nothing), "metadata offset");
  h = some_header();
  h.metadata_bytes = std::numeric_limits<std::uint64_t>::max();
  says(decode_changed(h, nothing), "metadata bytes");
}

TEST_CASE("an index entry comes back as it was written") {
  for (const Layer layer : {Layer::heights, Layer::imagery, Layer::rqt}) {
    IndexEntry entry = some_entry();
    entry.layer = layer;
    entry.flags = layer == Layer::heights ? kHasVoids : layer == Layer::imagery ? kHasAlpha : 0;
    std::vector<std::byte> bytes;
    append_entry(entry, bytes);
    REQUIRE(bytes.size() == kIndexEntryBytes);
    const auto back = decode_entry(bytes);
    REQUIRE(back.ok());
    CHECK(*back == entry);
  }
}

TEST_CASE("an index entry with a field out of range is refused") {
  const auto with = [](auto change) {
    IndexEntry entry = some_entry();
    change(entry);
    return entry;
  };
  REQUIRE_FALSE(refused(some_entry()));
  CHECK(refused(with([](auto& e) { e.layer = static_cast<Layer>(3); })));
  CHECK(refused(with([](auto& e) { e.flags = 8; })));
  CHECK(refused(with([](auto& e) { e.flags = kHasAlpha; })));
  CHECK(refused(with([](auto& e) { e.layer = Layer::imagery; })));
  CHECK(refused(with([](auto& e) { e.id.level = -10; })));
  CHECK(refused(with([](auto& e) { e.id.level = 21; })));
  CHECK(refused(with([](auto& e) { e.id.x = 45; })));
  CHECK(refused(with([](auto& e) { e.id.y = -1; })));
  CHECK(refused(with([](auto& e) { e.bytes = 0; })));
  CHECK(refused(with([](auto& e) { e.offset = 95; })));
  CHECK(refused(with([](auto& e) { e.flags = kConstant; })));
  CHECK(refused(with([](auto& e) { e.max_quanta = -401; })));
  CHECK(refused(with([](auto& e) { e.geometric_error_m = -1; })));
  CHECK(refused(with([](auto& e) { e.geometric_error_m = std::numeric_limits<float>::quiet_NaN(); })));

  IndexEntry constant = some_entry();
  constant.flags = kConstant;
  constant.offset = constant.checksum = constant.bytes = 0;
  CHECK(refused(constant));  // min and max differ
  constant.max_quanta = constant.min_quanta;
  CHECK_FALSE(refused(constant));
  constant.flags = kConstant | kHasVoids;
  CHECK(refused(constant));

  std::vector<std::byte> bytes;
  append_entry(some_entry(), bytes);
  bytes[46] = std::byte{1};
  CHECK_FALSE(decode_entry(bytes).ok());
}

}  // namespace cairn
