#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Refuses an entry with a field out of range, or with fields that contradict each other.
Status check_entry(const IndexEntry& entry);

/// Adds an entry to the sums over its level.
void add_to_level(const IndexEntry& entry, PackLevel& level);

/// An entry by itself, as a journal and a writer's scratch file hold it. A pack's index has its own form
/// (format/index_page.h).
inline constexpr std::size_t kEntryRecordBytes = 48;
void append_entry(const IndexEntry& entry, std::vector<std::byte>& out);
/// REQUIRES: bytes.size() == kEntryRecordBytes. bad_data where check_entry() refuses it.
Result<IndexEntry> decode_entry(std::span<const std::byte> bytes);

}  // namespace cairn
