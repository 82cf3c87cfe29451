#include "cairn/pack_layout.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "format/checksum.h"
#include "format/index_entry.h"

namespace cairn {
namespace {

PackHeader some_header() {
  PackHeader header;
  header.vertical_datum = VerticalDatum::ellipsoid;
  header.quantum_m = 0.1;
  header.entry_count = 7;
  header.index_offset = 20000;
  header.metadata_offset = 20500;
  header.metadata_bytes = 55;
  header.metadata_checksum = 99;
  header.root_bytes = 800;
  header.root_checksum = 0x0123456789ABCDEF;
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

/// Encodes the header, applies `change` to its bytes, and puts the right id and checksum under the result.
template <class Change>
Result<PackHeader> decode_changed(const PackHeader& header, Change change) {
  auto bytes = encode_header(header);
  change(bytes);
  const PackId id = long_checksum(std::span(bytes).first(224));
  std::copy(id.begin(), id.end(), bytes.begin() + 224);
  const std::uint64_t sum = checksum(std::span(bytes).first(248));
  std::memcpy(bytes.data() + 248, &sum, 8);
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
  CHECK(back->file_bytes() == 20555);
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
  says(decode_changed(h, [](auto& b) { b[8] = std::byte{1}; }), "version");
  says(decode_changed(h, [](auto& b) { b[10] = std::byte{2}; }), "tile size");
  for (const std::size_t at : {12u, 15u, 156u, 159u, 168u, 223u, 240u, 247u}) {
    says(decode_changed(h, [at](auto& b) { b[at] = std::byte{1}; }), "reserved");
  }
  says(decode_changed(h, [](auto& b) { b[24] = std::byte{0}; }), "body");
  says(decode_changed(h, [](auto& b) { b[55] = std::byte{65}; }), "body");
  says(decode_changed(h, [](auto& b) { b[72] = std::byte{0}; }), "vertical datum");
  says(decode_changed(h, [](auto& b) { b[111] = std::byte{65}; }), "vertical datum");
  for (const double quantum : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    h = some_header();
    h.quantum_m = quantum;
    says(decode_changed(h, nothing), "quantum");
  }
  for (const double axis : {0.0, -1.0, 7e6, std::nan("")}) {
    h = some_header();
    h.body.shape.semi_minor_m = axis;
    says(decode_changed(h, nothing), "semi-axes");
  }
  h = some_header();
  h.index_offset = kPackStartBytes - 1;
  says(decode_changed(h, nothing), "index offset");
  h = some_header();
  h.metadata_offset = h.index_offset - 1;
  says(decode_changed(h, nothing), "metadata offset");
  h = some_header();
  h.metadata_bytes = std::numeric_limits<std::uint64_t>::max();
  says(decode_changed(h, nothing), "metadata bytes");
  h = some_header();
  h.root_bytes = kPackStartBytes - kPackHeaderBytes + 1;
  says(decode_changed(h, nothing), "root bytes");
  const auto bytes = encode_header(some_header());
  auto other_id = bytes;
  other_id[230] ^= std::byte{1};
  const std::uint64_t sum = checksum(std::span(other_id).first(248));
  std::memcpy(other_id.data() + 248, &sum, 8);
  says(decode_header(other_id), "pack id");
}

TEST_CASE("a header names its body and its datum, also those that the program does not know") {
  PackHeader header = some_header();
  header.body = {"Moon", {1737400, 1737400}};
  header.vertical_datum = VerticalDatum::unknown;
  header.other_datum = "LOLA sphere";
  const auto back = decode_header(encode_header(header));
  REQUIRE(back.ok());
  CHECK(back->body == header.body);
  CHECK(back->datum_name() == "LOLA sphere");
  CHECK(back->vertical_datum == VerticalDatum::unknown);
  for (const auto datum : {VerticalDatum::unknown, VerticalDatum::egm96, VerticalDatum::ellipsoid}) {
    header.other_datum.clear();
    header.vertical_datum = datum;
    const auto known = decode_header(encode_header(header));
    REQUIRE(known.ok());
    CHECK(known->vertical_datum == datum);
    CHECK(known->datum_name() == to_string(datum));
  }
}

TEST_CASE("packs that differ in anything the header speaks of have different ids") {
  std::set<std::string> ids;
  const auto note = [&](auto change) {
    PackHeader header = some_header();
    change(header);
    ids.insert(to_string(decode_header(encode_header(header))->id));
  };
  note([](PackHeader&) {});
  note([](PackHeader& h) { h.root_checksum ^= 1; });
  note([](PackHeader& h) { h.metadata_checksum ^= 1; });
  note([](PackHeader& h) { h.quantum_m = 0.2; });
  note([](PackHeader& h) { h.body.name = "Mars"; });
  note([](PackHeader& h) { h.other_datum = "NAVD88"; });
  CHECK(ids.size() == 6);
  CHECK(ids.begin()->size() == 32);
}

TEST_CASE("an index entry comes back as it was written") {
  for (const Layer layer : {Layer::heights, Layer::imagery, Layer::rqt, Layer::objects, Layer::water,
                            Layer::models}) {
    IndexEntry entry = some_entry();
    entry.layer = layer;
    entry.flags = layer == Layer::heights ? kHasVoids : layer == Layer::imagery ? kHasAlpha : 0;
    std::vector<std::byte> bytes;
    append_entry(entry, bytes);
    REQUIRE(bytes.size() == kEntryRecordBytes);
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
  CHECK(refused(with([](auto& e) { e.layer = static_cast<Layer>(6); })));
  CHECK(refused(with([](auto& e) { e.flags = 16; })));
  CHECK(refused(with([](auto& e) { e.flags = kHasAlpha; })));
  CHECK(refused(with([](auto& e) { e.layer = Layer::imagery; })));
  CHECK(refused(with([](auto& e) { e.id.level = -10; })));
  CHECK(refused(with([](auto& e) { e.id.level = 21; })));
  CHECK(refused(with([](auto& e) { e.id.x = 45; })));
  CHECK(refused(with([](auto& e) { e.id.y = -1; })));
  CHECK(refused(with([](auto& e) { e.bytes = 0; })));
  CHECK(refused(with([](auto& e) { e.offset = kPackStartBytes - 1; })));
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
  constant.flags = kConstant | kSharedBlock;
  CHECK(refused(constant));

  std::vector<std::byte> bytes;
  append_entry(some_entry(), bytes);
  bytes[46] = std::byte{1};
  CHECK_FALSE(decode_entry(bytes).ok());
}

}  // namespace cairn
