#include "format/pack_writer.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <string>
#include <system_error>
#include <unordered_map>

#include "format/checksum.h"
#include "format/file.h"

namespace cairn {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kLargeBlock = std::size_t{64} << 10;  // costs less to write by itself than to copy
constexpr std::size_t kIndexPieceEntries = 16384;
constexpr std::uint64_t kSyncBytes = std::uint64_t{8} << 20;

std::filesystem::path part_of(const std::filesystem::path& target) {
  return target.string() + ".part";
}

}  // namespace

struct PackWriter::State {
  State(File part, std::filesystem::path target_path, const PackHeader& pack_header)
      : file(std::move(part)), target(std::move(target_path)), header(pack_header) {
    buffer.reserve(kBufferBytes);
  }

  std::uint64_t position() const { return flushed + buffer.size(); }
  Status append(std::span<const std::byte> bytes);
  Status flush();
  void start_sync();
  Result<bool> same_as_stored(const IndexEntry& stored, std::span<const std::byte> block);
  Result<const IndexEntry*> find_equal(std::uint64_t sum, std::span<const std::byte> block);
  void remember(std::size_t entry_index);
  Status write_index();
  Status write_header();

  File file;
  std::filesystem::path target;
  PackHeader header;
  std::vector<IndexEntry> entries;                             // in the order of add()
  std::unordered_multimap<std::uint64_t, std::size_t> blocks;  // checksum -> the entry that brought the block
  std::uint64_t flushed = 0;                                   // bytes handed to the file
  std::uint64_t sync_started = 0;                              // and begun to be put on the disk
  std::vector<std::byte> buffer;                               // bytes that follow them
  std::vector<std::byte> scratch;                              // a stored block, read back to be compared
};

Status PackWriter::State::append(std::span<const std::byte> bytes) {
  const bool is_large = bytes.size() > kLargeBlock;
  if (is_large || buffer.size() + bytes.size() > kBufferBytes) {
    if (const Status status = flush(); !status) return status;
  }
  if (is_large) {
    const Status status = file.write(flushed, bytes);
    if (status) flushed += bytes.size();
    return status;
  }
  buffer.insert(buffer.end(), bytes.begin(), bytes.end());
  return {};
}

Status PackWriter::State::flush() {
  if (const Status status = file.write(flushed, buffer); !status) return status;
  flushed += buffer.size();
  buffer.clear();
  start_sync();
  return {};
}

// So that finish() need not wait for all of the pack. Whole pieces, whose last pages nobody writes again.
void PackWriter::State::start_sync() {
  const std::uint64_t end = flushed / kSyncBytes * kSyncBytes;
  if (end <= sync_started) return;
  file.start_sync(sync_started, end - sync_started);
  sync_started = end;
}

Result<bool> PackWriter::State::same_as_stored(const IndexEntry& stored, std::span<const std::byte> block) {
  if (stored.bytes != block.size()) return false;
  if (stored.offset >= flushed) {
    return std::memcmp(buffer.data() + (stored.offset - flushed), block.data(), block.size()) == 0;
  }
  scratch.resize(block.size());
  if (const Status status = file.read(stored.offset, scratch); !status) return status.error();
  return std::memcmp(scratch.data(), block.data(), block.size()) == 0;
}

Result<const IndexEntry*> PackWriter::State::find_equal(std::uint64_t sum, std::span<const std::byte> block) {
  const auto [first, last] = blocks.equal_range(sum);
  for (auto it = first; it != last; ++it) {
    const IndexEntry& stored = entries[it->second];
    const Result<bool> same = same_as_stored(stored, block);
    if (!same) return same.error();
    if (*same) return &stored;
  }
  return nullptr;
}

void PackWriter::State::remember(std::size_t entry_index) {
  const IndexEntry& entry = entries[entry_index];
  const auto [first, last] = blocks.equal_range(entry.checksum);
  for (auto it = first; it != last; ++it) {
    if (entries[it->second].offset == entry.offset) return;
  }
  blocks.emplace(entry.checksum, entry_index);
}

Status PackWriter::State::write_index() {
  std::sort(entries.begin(), entries.end(), entry_before);
  header.index_offset = position();
  header.index_count = entries.size();
  ChecksumStream sum;
  std::vector<std::byte> piece;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i > 0 && !entry_before(entries[i - 1], entries[i])) {
      return failed(target.string() + ": tile " + to_string(entries[i].id) + " was added twice");
    }
    append_entry(entries[i], piece);
    if ((i + 1) % kIndexPieceEntries != 0 && i + 1 != entries.size()) continue;
    sum.add(piece);
    if (const Status status = append(piece); !status) return status;
    piece.clear();
  }
  header.index_checksum = sum.value();
  return {};
}

Status PackWriter::State::write_header() {
  if (const Status status = flush(); !status) return status;
  // The header is what makes a pack of the file, so everything it speaks of is on the disk before it.
  if (const Status status = file.sync(); !status) return status;
  if (const Status status = file.write(0, encode_header(header)); !status) return status;
  return file.sync();
}

PackWriter::PackWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PackWriter::PackWriter(PackWriter&&) noexcept = default;
PackWriter& PackWriter::operator=(PackWriter&&) noexcept = default;
PackWriter::~PackWriter() = default;

Result<PackWriter> PackWriter::create(const std::filesystem::path& target, const PackHeader& header) {
  return reopen(target, header, {});
}

Result<PackWriter> PackWriter::reopen(const std::filesystem::path& target, const PackHeader& header,
                                      std::span<const IndexEntry> entries) {
  Result<File> file = File::open_to_write(part_of(target));
  if (!file) return file.error();
  auto state = std::make_unique<State>(std::move(*file), target, header);
  state->entries.assign(entries.begin(), entries.end());
  std::uint64_t end = kPackHeaderBytes;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].bytes == 0) continue;
    end = std::max(end, entries[i].offset + entries[i].bytes);
    state->remember(i);
  }
  const Result<std::uint64_t> size = state->file.size();
  if (!size) return size.error();
  if (!entries.empty() && *size < end) {
    return bad_data(part_of(target).string() + ": expected " + std::to_string(end) +
                    " bytes or more, found " + std::to_string(*size));
  }
  if (const Status status = state->file.truncate(end); !status) return status.error();
  // Zeros where the header goes: until finish() the file opens nowhere, also if it was once finished.
  const std::array<std::byte, kPackHeaderBytes> blank{};
  if (const Status status = state->file.write(0, blank); !status) return status.error();
  state->flushed = end;
  return PackWriter(std::move(state));
}

Result<IndexEntry> PackWriter::add(IndexEntry entry, std::span<const std::byte> block) {
  assert(state_ && is_valid(entry.id));
  assert(block.empty() == ((entry.flags & kConstant) != 0));
  assert(block.size() <= std::numeric_limits<std::uint32_t>::max());
  entry.offset = 0;
  entry.bytes = static_cast<std::uint32_t>(block.size());
  entry.checksum = block.empty() ? 0 : checksum(block);
  if (!block.empty()) {
    const Result<const IndexEntry*> equal = state_->find_equal(entry.checksum, block);
    if (!equal) return equal.error();
    entry.offset = *equal != nullptr ? (*equal)->offset : state_->position();
    if (*equal == nullptr) {
      if (const Status status = state_->append(block); !status) return status.error();
      state_->blocks.emplace(entry.checksum, state_->entries.size());
    }
  }
  state_->entries.push_back(entry);
  return entry;
}

std::uint64_t PackWriter::position() const {
  return state_->position();
}

const std::vector<IndexEntry>& PackWriter::entries() const {
  return state_->entries;
}

Result<std::vector<std::byte>> PackWriter::read_block(const IndexEntry& entry) const {
  std::vector<std::byte> block(entry.bytes);
  if (const Status status = state_->file.read(entry.offset, block); !status) return status.error();
  if (checksum(block) != entry.checksum) {
    return bad_data(part_of(state_->target).string() + ": " + to_string(entry.layer) + " " +
                    to_string(entry.id) + ": expected the block as it was written, found another");
  }
  return block;
}

Status PackWriter::flush() {
  return state_->flush();
}

Status PackWriter::finish(std::string_view metadata_json) {
  assert(state_);
  const auto metadata = std::as_bytes(std::span(metadata_json));
  if (const Status status = state_->write_index(); !status) return status;
  state_->header.metadata_offset = state_->position();
  state_->header.metadata_bytes = metadata.size();
  state_->header.metadata_checksum = checksum(metadata);
  if (const Status status = state_->append(metadata); !status) return status;
  if (const Status status = state_->write_header(); !status) return status;
  const Status renamed = rename_durably(part_of(state_->target), state_->target);
  if (renamed) state_.reset();
  return renamed;
}

void PackWriter::abandon() {
  std::error_code ignored;
  std::filesystem::remove(part_of(state_->target), ignored);
  state_.reset();
}

}  // namespace cairn
