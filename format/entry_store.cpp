#include "format/entry_store.h"

#include <algorithm>
#include <queue>
#include <span>

#include "format/index_entry.h"
#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::size_t kRunEntries = std::size_t{1} << 16;
constexpr std::size_t kReadEntries = 512;

bool entry_before(const IndexEntry& a, const IndexEntry& b) {
  return index_key_of(a) < index_key_of(b);
}

}  // namespace

/// The entries of a run, one after the other.
class EntryStore::RunReader {
 public:
  RunReader(const File& scratch, const Run& run) : scratch_(&scratch), rest_(run) {}
  /// Entries that are in memory.
  explicit RunReader(std::vector<IndexEntry> sorted) : buffer_(std::move(sorted)) {}

  /// False at the end.
  Result<bool> next() {
    if (++at_ < buffer_.size()) return true;
    if (rest_.entries == 0) return false;
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(rest_.entries, kReadEntries));
    std::vector<std::byte> bytes(count * kEntryRecordBytes);
    if (const Status status = scratch_->read(rest_.offset, bytes); !status) return status.error();
    rest_.offset += bytes.size();
    rest_.entries -= count;
    buffer_.clear();
    at_ = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto entry = decode_entry(std::span(bytes).subspan(i * kEntryRecordBytes, kEntryRecordBytes));
      if (!entry) return entry.error();
      buffer_.push_back(*entry);
    }
    return true;
  }
  const IndexEntry& entry() const { return buffer_[at_]; }

 private:
  const File* scratch_ = nullptr;
  Run rest_;
  std::vector<IndexEntry> buffer_;
  std::size_t at_ = static_cast<std::size_t>(-1);  // next() comes before entry()
};

Status EntryStore::add(const IndexEntry& entry) {
  latest_.push_back(entry);
  return latest_.size() < kRunEntries ? Status() : write_run();
}

Status EntryStore::write_run() {
  if (!scratch_) {
    auto file = File::open_scratch(folder_);
    if (!file) return file.error();
    scratch_ = std::move(*file);
  }
  std::sort(latest_.begin(), latest_.end(), entry_before);
  std::vector<std::byte> bytes;
  bytes.reserve(latest_.size() * kEntryRecordBytes);
  for (const IndexEntry& entry : latest_) append_entry(entry, bytes);
  if (const Status status = scratch_->write(scratch_bytes_, bytes); !status) return status;
  runs_.push_back({scratch_bytes_, latest_.size()});
  scratch_bytes_ += bytes.size();
  latest_.clear();
  return {};
}

Status EntryStore::visit(const std::function<Status(const IndexEntry&)>& visit) const {
  std::vector<RunReader> readers;
  for (const Run& run : runs_) readers.emplace_back(*scratch_, run);
  std::vector<IndexEntry> sorted = latest_;
  std::sort(sorted.begin(), sorted.end(), entry_before);
  readers.emplace_back(std::move(sorted));

  const auto later = [&readers](std::size_t a, std::size_t b) {
    return entry_before(readers[b].entry(), readers[a].entry());
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  const auto advance = [&](std::size_t i) -> Status {
    const auto more = readers[i].next();
    if (!more) return more.error();
    if (*more) next.push(i);
    return {};
  };
  for (std::size_t i = 0; i < readers.size(); ++i) {
    if (Status status = advance(i); !status) return status;
  }
  while (!next.empty()) {
    const std::size_t i = next.top();
    next.pop();
    if (Status status = visit(readers[i].entry()); !status) return status;
    if (Status status = advance(i); !status) return status;
  }
  return {};
}

}  // namespace cairn
