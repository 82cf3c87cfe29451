#include "builder/journal.h"

#include <array>
#include <cassert>
#include <cstring>

#include "format/bytes.h"
#include "format/checksum.h"

namespace cairn {
namespace {

constexpr std::array<char, 8> kMagic = {'C', 'A', 'I', 'R', 'N', 'J', 'N', '1'};
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint64_t);
constexpr std::size_t kRecordHeaderBytes = 2 * sizeof(std::uint64_t);

std::vector<std::byte> encode(const UnitRecord& record) {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.write(static_cast<std::uint32_t>(record.entries.size()));
  for (const IndexEntry& entry : record.entries) append_entry(entry, bytes);
  append_baked_tile(record.root, bytes);
  return bytes;
}

Result<UnitRecord> decode(std::span<const std::byte> bytes, int tile_size) {
  ByteReader reader(bytes);
  UnitRecord record;
  for (auto n = reader.read<std::uint32_t>(); n > 0; --n) {
    const auto entry_bytes = reader.take(kIndexEntryBytes);
    if (!reader.ok()) return bad_data("journal: an entry: expected more bytes");
    auto entry = decode_entry(entry_bytes);
    if (!entry) return entry.error();
    record.entries.push_back(*entry);
  }
  auto root = read_baked_tile(reader, tile_size);
  if (!root) return root.error();
  record.root = std::move(*root);
  return record;
}

}  // namespace

std::filesystem::path Journal::path_for(const std::filesystem::path& target) {
  return std::filesystem::path(target).concat(".journal");
}

Result<Journal> Journal::create(const std::filesystem::path& target, std::uint64_t fingerprint) {
  auto file = File::open_to_write(path_for(target));
  if (!file) return file.error();
  if (auto status = file->truncate(0); !status) return status.error();
  std::vector<std::byte> header;
  ByteWriter writer(header);
  writer.append(std::as_bytes(std::span(kMagic)));
  writer.write(fingerprint);
  if (auto status = file->write(0, header); !status) return status.error();
  Journal journal(std::move(*file));
  journal.end_ = kHeaderBytes;
  return journal;
}

Result<Journal> Journal::reopen(const std::filesystem::path& target, const std::vector<UnitRecord>& records) {
  assert(!records.empty());
  auto file = File::open_to_write(path_for(target));
  if (!file) return file.error();
  if (auto status = file->truncate(records.back().end); !status) return status.error();
  Journal journal(std::move(*file));
  journal.end_ = records.back().end;
  return journal;
}

std::vector<UnitRecord> Journal::read(const std::filesystem::path& target, std::uint64_t fingerprint,
                                      int tile_size) {
  std::vector<UnitRecord> records;
  const auto file = File::open_to_read(path_for(target));
  if (!file) return records;
  const std::uint64_t size = file->size().ok() ? *file->size() : 0;
  std::array<std::byte, kHeaderBytes> header{};
  if (size < kHeaderBytes || !file->read(0, header)) return records;
  ByteReader reader(header);
  if (std::memcmp(reader.take(kMagic.size()).data(), kMagic.data(), kMagic.size()) != 0) return records;
  if (reader.read<std::uint64_t>() != fingerprint) return records;

  for (std::uint64_t at = kHeaderBytes; size - at >= kRecordHeaderBytes;) {
    std::array<std::byte, kRecordHeaderBytes> record_header{};
    if (!file->read(at, record_header)) break;
    ByteReader lengths(record_header);
    const auto length = lengths.read<std::uint64_t>();
    const auto sum = lengths.read<std::uint64_t>();
    at += kRecordHeaderBytes;
    if (length > size - at) break;
    std::vector<std::byte> bytes(static_cast<std::size_t>(length));
    if (!file->read(at, bytes) || checksum(bytes) != sum) break;
    auto record = decode(bytes, tile_size);
    if (!record) break;
    at += length;
    record->end = at;
    records.push_back(std::move(*record));
  }
  return records;
}

Status Journal::append(const UnitRecord& record) {
  const std::vector<std::byte> body = encode(record);
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.write(static_cast<std::uint64_t>(body.size()));
  writer.write(checksum(body));
  writer.append(body);
  if (auto status = file_.write(end_, bytes); !status) return status;
  end_ += bytes.size();
  return {};
}

}  // namespace cairn
