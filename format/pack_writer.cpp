#include "format/pack_writer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "format/checksum.h"
#include "format/entry_store.h"
#include "format/file.h"
#include "format/index_entry.h"
#include "format/index_writer.h"
#include "format/recent_blocks.h"
#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kLargeBlock = std::size_t{64} << 10;  // costs less to write by itself than to copy
constexpr std::uint64_t kSyncBytes = std::uint64_t{8} << 20;

std::filesystem::path part_of(const std::filesystem::path& target) {
  return target.string() + ".part";
}

}  // namespace

struct PackWriter::State {
  State(File part, std::filesystem::path target_path, const PackHeader& pack_header)
      : file(std::move(part)),
        target(std::move(target_path)),
        header(pack_header),
        entries(target.parent_path()) {
    header.entry_count = 0;  // a header that was read counts the tiles of its own pack
    buffer.reserve(kBufferBytes);
  }

  std::uint64_t position() const { return flushed + buffer.size(); }
  Status append(std::span<const std::byte> bytes);
  Status flush();
  void start_sync();
  Result<bool> same_as_stored(const RecentBlocks::Block& stored, std::span<const std::byte> block);
  Result<std::optional<std::uint64_t>> find_equal(std::uint64_t sum, std::span<const std::byte> block);
  Status note(const IndexEntry& entry);
  std::vector<PackLevel> level_rows() const;
  Result<std::vector<std::byte>> write_index();
  Status write_start(std::span<const std::byte> root);

  File file;
  std::filesystem::path target;
  PackHeader header;
  EntryStore entries;
  std::map<std::pair<Layer, int>, PackLevel> levels;
  RecentBlocks blocks;
  std::uint64_t flushed = 0;       // bytes handed to the file
  std::uint64_t sync_started = 0;  // and begun to be put on the disk
  std::vector<std::byte> buffer;   // bytes that follow them
  std::vector<std::byte> scratch;  // a stored block, read back to be compared
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

Result<bool> PackWriter::State::same_as_stored(const RecentBlocks::Block& stored,
                                               std::span<const std::byte> block) {
  if (stored.bytes != block.size()) return false;
  if (stored.offset >= flushed) {
    return std::memcmp(buffer.data() + (stored.offset - flushed), block.data(), block.size()) == 0;
  }
  scratch.resize(block.size());
  if (const Status status = file.read(stored.offset, scratch); !status) return status.error();
  return std::memcmp(scratch.data(), block.data(), block.size()) == 0;
}

// Where an equal block lies.
Result<std::optional<std::uint64_t>> PackWriter::State::find_equal(std::uint64_t sum,
                                                                   std::span<const std::byte> block) {
  std::optional<std::uint64_t> offset;
  Status status;
  blocks.find(sum, [&](const RecentBlocks::Block& stored) {
    const Result<bool> same = same_as_stored(stored, block);
    if (!same) status = same.error();
    if (same && *same) offset = stored.offset;
    return !same || *same;
  });
  if (!status) return status.error();
  return offset;
}

Status PackWriter::State::note(const IndexEntry& entry) {
  if (entry.bytes != 0 && (entry.flags & kSharedBlock) == 0)
    blocks.add({entry.checksum, entry.offset, entry.bytes});
  const auto [level, is_new] =
      levels.try_emplace({entry.layer, entry.id.level}, PackLevel{entry.layer, entry.id.level});
  add_to_level(entry, level->second);
  return entries.add(entry);
}

std::vector<PackLevel> PackWriter::State::level_rows() const {
  std::vector<PackLevel> rows;
  for (const auto& [key, level] : levels) rows.push_back(level);
  return rows;
}

// Returns the root.
Result<std::vector<std::byte>> PackWriter::State::write_index() {
  header.index_offset = position();
  IndexWriter index(level_rows(), [this](std::span<const std::byte> page) -> Result<std::uint64_t> {
    const std::uint64_t offset = position();
    if (const Status status = append(page); !status) return status.error();
    return offset;
  });
  std::optional<IndexEntry> before;
  const Status written = entries.visit([&](const IndexEntry& entry) -> Status {
    if (before && index_key_of(*before) == index_key_of(entry))
      return failed(target.string() + ": tile " + to_string(entry.id) + " was added twice");
    before = entry;
    ++header.entry_count;
    return index.add(entry);
  });
  if (!written) return written.error();
  return index.finish();
}

// Header and root are what makes a pack of the file, so everything they speak of is on the disk before them.
Status PackWriter::State::write_start(std::span<const std::byte> root) {
  if (const Status status = flush(); !status) return status;
  if (const Status status = file.sync(); !status) return status;
  std::vector<std::byte> start(kPackStartBytes);
  std::copy(root.begin(), root.end(), start.begin() + kPackHeaderBytes);
  header.root_bytes = static_cast<std::uint32_t>(root.size());
  header.root_checksum = checksum(std::span(start).subspan(kPackHeaderBytes));
  const auto encoded = encode_header(header);
  std::copy(encoded.begin(), encoded.end(), start.begin());
  if (const Status status = file.write(0, start); !status) return status;
  return file.sync();
}

PackWriter::PackWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PackWriter::PackWriter(PackWriter&&) noexcept = default;
PackWriter& PackWriter::operator=(PackWriter&&) noexcept = default;
PackWriter::~PackWriter() = default;

Result<PackWriter> PackWriter::create(const std::filesystem::path& target, const PackHeader& header) {
  return reopen(target, header, [](const TakeEntry&) { return Status(); });
}

Result<PackWriter> PackWriter::reopen(const std::filesystem::path& target, const PackHeader& header,
                                      const std::function<Status(const TakeEntry&)>& give_entries) {
  Result<File> file = File::open_to_write(part_of(target));
  if (!file) return file.error();
  auto state = std::make_unique<State>(std::move(*file), target, header);
  std::uint64_t end = kPackStartBytes;
  bool any = false;
  const Status taken = give_entries([&](const IndexEntry& entry) {
    any = true;
    if (entry.bytes != 0) end = std::max(end, entry.offset + entry.bytes);
    return state->note(entry);
  });
  if (!taken) return taken.error();
  const Result<std::uint64_t> size = state->file.size();
  if (!size) return size.error();
  if (any && *size < end) {
    return bad_data(part_of(target).string() + ": expected " + std::to_string(end) +
                    " bytes or more, found " + std::to_string(*size));
  }
  if (const Status status = state->file.truncate(end); !status) return status.error();
  // Zeros where header and root go: until finish() the file opens nowhere, also if it was once finished.
  const std::vector<std::byte> blank(kPackStartBytes);
  if (const Status status = state->file.write(0, blank); !status) return status.error();
  state->flushed = end;
  return PackWriter(std::move(state));
}

Result<IndexEntry> PackWriter::add(IndexEntry entry, std::span<const std::byte> block) {
  assert(state_ && is_valid(entry.id));
  assert(block.empty() == ((entry.flags & kConstant) != 0));
  assert(block.size() <= std::numeric_limits<std::uint32_t>::max());
  entry.flags = static_cast<std::uint16_t>(entry.flags & ~kSharedBlock);
  entry.offset = 0;
  entry.bytes = static_cast<std::uint32_t>(block.size());
  entry.checksum = block.empty() ? 0 : checksum(block);
  if (!block.empty()) {
    const auto equal = state_->find_equal(entry.checksum, block);
    if (!equal) return equal.error();
    entry.offset = equal->value_or(state_->position());
    if (*equal) {
      entry.flags |= kSharedBlock;
    } else if (const Status status = state_->append(block); !status) {
      return status.error();
    }
  }
  if (const Status status = state_->note(entry); !status) return status.error();
  return entry;
}

std::uint64_t PackWriter::position() const {
  return state_->position();
}

std::vector<PackLevel> PackWriter::levels() const {
  return state_->level_rows();
}

Status PackWriter::visit_entries(const TakeEntry& visit) const {
  return state_->entries.visit(visit);
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
  const auto root = state_->write_index();
  if (!root) return root.error();
  state_->header.metadata_offset = state_->position();
  state_->header.metadata_bytes = metadata.size();
  state_->header.metadata_checksum = checksum(metadata);
  if (const Status status = state_->append(metadata); !status) return status;
  if (const Status status = state_->write_start(*root); !status) return status;
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
