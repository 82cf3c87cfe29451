#include "builder/bake/journal.h"

#include <cassert>
#include <cstring>

#include "format/bytes.h"
#include "format/checksum.h"
#include "format/index_entry.h"

namespace cairn {
namespace {

constexpr std::size_t kHeaderBytes = Journal::kMagic.size() + sizeof(std::uint64_t);
constexpr std::size_t kRecordHeaderBytes = 2 * sizeof(std::uint64_t);

// A tile that is not in the pack yet has no place there. A record of it has the first one that a block can
// have, since entries without a place are refused.
IndexEntry with_place(const TileBlock& tile) {
  IndexEntry entry = tile.entry;
  if (!tile.block.empty()) entry.offset = kPackStartBytes;
  entry.bytes = static_cast<std::uint32_t>(tile.block.size());
  return entry;
}

// All of a record but its root.
std::vector<std::byte> encode(const UnitRecord& record) {
  std::vector<std::byte> bytes;
  bytes.reserve(2 * sizeof(std::uint32_t) + (record.entries.size() + 1) * kEntryRecordBytes);
  ByteWriter writer(bytes);
  writer.write(static_cast<std::uint32_t>(record.entries.size()));
  for (const IndexEntry& entry : record.entries) append_entry(entry, bytes);
  writer.write(static_cast<std::uint32_t>(record.held ? 1 : 0));
  if (record.held) {
    append_entry(with_place(*record.held), bytes);
    writer.append(record.held->block);
  }
  return bytes;
}

Result<IndexEntry> take_entry(ByteReader& reader) {
  const auto bytes = reader.take(kEntryRecordBytes);
  if (!reader.ok()) return bad_data("journal: an entry: expected more bytes");
  return decode_entry(bytes);
}

// The root may be most of a record, and stays where it is read.
Result<UnitRecord> decode(std::vector<std::byte>&& bytes) {
  ByteReader reader(bytes);
  UnitRecord record;
  for (auto n = reader.read<std::uint32_t>(); n > 0; --n) {
    const auto entry = take_entry(reader);
    if (!entry) return entry.error();
    record.entries.push_back(*entry);
  }
  if (reader.read<std::uint32_t>() != 0) {
    const auto entry = take_entry(reader);
    if (!entry) return entry.error();
    const auto block = reader.take(entry->bytes);
    record.held = TileBlock{*entry, {block.begin(), block.end()}};
  }
  if (!reader.ok()) return bad_data("journal: a record: expected more bytes");
  const auto before = static_cast<std::ptrdiff_t>(bytes.size() - reader.remaining());
  record.root = std::move(bytes);
  record.root.erase(record.root.begin(), record.root.begin() + before);
  return record;
}

struct PlacedRecord {
  UnitRecord record;
  RecordPlace place;
};

// The record that starts at `at`; nullopt where it is not whole.
std::optional<PlacedRecord> read_record(const File& file, std::uint64_t size, std::uint64_t at) {
  std::array<std::byte, kRecordHeaderBytes> header{};
  if (size - at < kRecordHeaderBytes || !file.read(at, header)) return std::nullopt;
  ByteReader lengths(header);
  const auto length = lengths.read<std::uint64_t>();
  const auto sum = lengths.read<std::uint64_t>();
  const std::uint64_t body = at + kRecordHeaderBytes;
  if (length > size - body) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(length));
  if (!file.read(body, bytes) || checksum(bytes) != sum) return std::nullopt;
  auto record = decode(std::move(bytes));
  if (!record) return std::nullopt;
  return PlacedRecord{std::move(*record), {at, body + length}};
}

// Nullopt where the file holds no record, or was not identified.
std::optional<std::uint64_t> read_fingerprint(const File& file) {
  const std::uint64_t size = file.size().ok() ? *file.size() : 0;
  std::array<std::byte, kHeaderBytes> header{};
  if (size <= kHeaderBytes || !file.read(0, header)) return std::nullopt;
  ByteReader reader(header);
  const auto magic = reader.take(Journal::kMagic.size());
  if (std::memcmp(magic.data(), Journal::kMagic.data(), magic.size()) != 0) return std::nullopt;
  return reader.read<std::uint64_t>();
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

Result<Journal> Journal::reopen(const std::filesystem::path& target,
                                const std::vector<RecordPlace>& records) {
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
  return file ? read_fingerprint(*file) : std::nullopt;
}

std::vector<RecordPlace> Journal::find_records(const std::filesystem::path& target, std::uint64_t fingerprint,
                                               const std::function<bool(const UnitRecord&)>& is_good) {
  std::vector<RecordPlace> places;
  if (fingerprint_of(target) != fingerprint) return places;
  const auto file = File::open_to_read(path_for(target));
  if (!file) return places;
  const std::uint64_t size = file->size().ok() ? *file->size() : 0;
  for (auto found = read_record(*file, size, kHeaderBytes); found && is_good(found->record);
       found = read_record(*file, size, places.back().end)) {
    places.push_back(found->place);
  }
  return places;
}

Result<UnitRecord> Journal::read(const RecordPlace& place) const {
  auto found = read_record(file_, place.end, place.start);
  if (!found) return bad_data(file_.path().string() + ": a record: expected it as it was, found it damaged");
  return std::move(found->record);
}

bool Journal::is_empty() const {
  return end_ <= kHeaderBytes;
}

// The root is written from where it is: it may be most of a megabyte.
Status Journal::append(const UnitRecord& record) {
  const std::vector<std::byte> entries = encode(record);
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

Status Journal::keep_as(const std::filesystem::path& name) {
  if (auto status = file_.sync(); !status) return status;
  return rename_durably(file_.path(), name);
}

JournalReader::JournalReader(File file, std::uint64_t fingerprint, std::uint64_t size)
    : file_(std::move(file)), fingerprint_(fingerprint), size_(size), at_(kHeaderBytes) {}

Result<JournalReader> JournalReader::open(const std::filesystem::path& path) {
  auto file = File::open_to_read(path);
  if (!file) return file.error();
  const auto size = file->size();
  if (!size) return size.error();
  const auto fingerprint = read_fingerprint(*file);
  if (!fingerprint)
    return bad_data(path.string() + ": expected the records of a bake, found another file or an empty one");
  return JournalReader(std::move(*file), *fingerprint, *size);
}

Result<std::optional<UnitRecord>> JournalReader::next() {
  if (at_ == size_) return std::optional<UnitRecord>();
  auto found = read_record(file_, size_, at_);
  if (!found)
    return bad_data(file_.path().string() + ": the record at byte " + std::to_string(at_) +
                    ": expected a whole one, found it damaged or cut off");
  at_ = found->place.end;
  return std::optional<UnitRecord>(std::move(found->record));
}

Result<UnitRecord> JournalReader::read(const RecordPlace& place) const {
  auto found = read_record(file_, place.end, place.start);
  if (!found)
    return bad_data(file_.path().string() + ": the record at byte " + std::to_string(place.start) +
                    ": expected it as it was, found it damaged");
  return std::move(found->record);
}

}  // namespace cairn
