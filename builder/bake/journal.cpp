#include "builder/bake/journal.h"

#include <cassert>
#include <cstring>

#include "format/bytes.h"
#include "format/checksum.h"

namespace cairn {
namespace {

constexpr std::size_t kHeaderBytes = Journal::kMagic.size() + sizeof(std::uint64_t);
constexpr std::size_t kRecordHeaderBytes = 2 * sizeof(std::uint64_t);

std::vector<std::byte> encode(const std::vector<IndexEntry>& entries) {
  std::vector<std::byte> bytes;
  bytes.reserve(sizeof(std::uint32_t) + entries.size() * kIndexEntryBytes);
  ByteWriter writer(bytes);
  writer.write(static_cast<std::uint32_t>(entries.size()));
  for (const IndexEntry& entry : entries) append_entry(entry, bytes);
  return bytes;
}

Result<UnitRecord> decode(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  UnitRecord record;
  for (auto n = reader.read<std::uint32_t>(); n > 0; --n) {
    const auto entry_bytes = reader.take(kIndexEntryBytes);
    if (!reader.ok()) return bad_data("journal: an entry: expected more bytes");
    auto entry = decode_entry(entry_bytes);
    if (!entry) return entry.error();
    record.entries.push_back(*entry);
  }
  const auto root = reader.take(reader.remaining());
  record.root.assign(root.begin(), root.end());
  return record;
}

// The record that starts at `at`; nullopt where it is not whole.
std::optional<UnitRecord> read_record(const File& file, std::uint64_t size, std::uint64_t at) {
  std::array<std::byte, kRecordHeaderBytes> header{};
  if (size - at < kRecordHeaderBytes || !file.read(at, header)) return std::nullopt;
  ByteReader lengths(header);
  const auto length = lengths.read<std::uint64_t>();
  const auto sum = lengths.read<std::uint64_t>();
  const std::uint64_t body = at + kRecordHeaderBytes;
  if (length > size - body) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(length));
  if (!file.read(body, bytes) || checksum(bytes) != sum) return std::nullopt;
  auto record = decode(bytes);
  if (!record) return std::nullopt;
  record->start = at;
  record->end = body + length;
  return std::move(*record);
}

}  // namespace

std::filesystem::path Journal::path_for(const std::filesystem::path& target) {
  return std::filesystem::path(target).concat(".journal");
}

Result<Journal> Journal::create(const std::filesystem::path& target) {
  auto file = File::open_to_write(path_for(target));
  if (!file) return file.error();
  if (auto status = file->truncate(0); !status) return status.error();
  Journal journal(std::move(*file));
  journal.end_ = kHeaderBytes;
  return journal;
}

Status Journal::identify(std::uint64_t fingerprint) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  writer.append(std::as_bytes(std::span(kMagic)));
  writer.write(fingerprint);
  return file_.write(0, header);
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

std::optional<std::uint64_t> Journal::fingerprint_of(const std::filesystem::path& target) {
  const auto file = File::open_to_read(path_for(target));
  if (!file) return std::nullopt;
  const std::uint64_t size = file->size().ok() ? *file->size() : 0;
  std::array<std::byte, kHeaderBytes> header{};
  if (size <= kHeaderBytes || !file->read(0, header)) return std::nullopt;
  ByteReader reader(header);
  if (std::memcmp(reader.take(kMagic.size()).data(), kMagic.data(), kMagic.size()) != 0) return std::nullopt;
  return reader.read<std::uint64_t>();
}

std::vector<UnitRecord> Journal::read(const std::filesystem::path& target, std::uint64_t fingerprint) {
  std::vector<UnitRecord> records;
  if (fingerprint_of(target) != fingerprint) return records;
  const auto file = File::open_to_read(path_for(target));
  if (!file) return records;
  const std::uint64_t size = file->size().ok() ? *file->size() : 0;
  for (auto record = read_record(*file, size, kHeaderBytes); record;
       record = read_record(*file, size, records.back().end)) {
    record->root = {};
    records.push_back(std::move(*record));
  }
  return records;
}

Result<std::vector<std::byte>> Journal::read_root(const UnitRecord& record) const {
  auto whole = read_record(file_, record.end, record.start);
  if (!whole) return bad_data(file_.path().string() + ": a record: expected it as it was, found it damaged");
  return std::move(whole->root);
}

bool Journal::is_empty() const {
  return end_ <= kHeaderBytes;
}

// The root is written from where it is: it may be most of a megabyte.
Status Journal::append(const UnitRecord& record) {
  const std::vector<std::byte> entries = encode(record.entries);
  ChecksumStream sum;
  sum.add(entries);
  sum.add(record.root);
  std::vector<std::byte> bytes;
  bytes.reserve(kRecordHeaderBytes + entries.size());
  ByteWriter writer(bytes);
  writer.write(static_cast<std::uint64_t>(entries.size() + record.root.size()));
  writer.write(sum.value());
  writer.append(entries);
  if (auto status = file_.write(end_, bytes); !status) return status;
  if (auto status = file_.write(end_ + bytes.size(), record.root); !status) return status;
  end_ += bytes.size() + record.root.size();
  return {};
}

}  // namespace cairn
