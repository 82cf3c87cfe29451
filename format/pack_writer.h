#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Writes one pack as `TARGET.part` and renames it when it is whole, so that a reader never finds half a
/// pack. The part is locked against other processes. Memory does not grow with the number of tiles. One
/// thread at a time. After an error of add(), flush() or finish() only abandon() or the destructor may be
/// called.
class PackWriter {
 public:
  using TakeEntry = std::function<Status(const IndexEntry&)>;

  /// Creates `TARGET.part`. The error is failed if the folder cannot be written.
  static Result<PackWriter> create(const std::filesystem::path& target, const PackHeader& header);

  /// Continues an existing `TARGET.part` after the blocks of some entries, which `give_entries` passes on in
  /// the order of add(). Everything after the last of them is cut off. The error is bad_data if the part is
  /// too short for them. REQUIRES: the caller has verified the checksums of these blocks.
  static Result<PackWriter> reopen(const std::filesystem::path& target, const PackHeader& header,
                                   const std::function<Status(const TakeEntry&)>& give_entries);

  PackWriter(PackWriter&&) noexcept;
  PackWriter& operator=(PackWriter&&) noexcept;
  ~PackWriter();  ///< closes `TARGET.part` and leaves it

  /// Appends a block and its entry; returns the entry with offset, bytes and checksum. A block that equals
  /// one of the last 65,536 is shared with it. REQUIRES: the block is empty if and only if the entry has
  /// kConstant; each tile is added once.
  Result<IndexEntry> add(IndexEntry entry, std::span<const std::byte> block);

  /// Returns the bytes of header, root and the blocks so far.
  std::uint64_t position() const;

  /// Returns what was added of each level so far, ascending by layer, then level.
  std::vector<PackLevel> levels() const;

  /// Calls `visit` with each entry so far, in the order of the index. Ends at the first error.
  Status visit_entries(const TakeEntry& visit) const;

  /// The block of an entry that add() returned, checked by its checksum. REQUIRES: flush() since then. Any
  /// thread, while another one adds.
  Result<std::vector<std::byte>> read_block(const IndexEntry& entry) const;

  /// Writes all blocks so far to the file: they outlive a killed process, but not a power cut.
  Status flush();

  /// Writes index, metadata and header, syncs, and renames to the target. Nothing may be called after it.
  Status finish(std::string_view metadata_json);

  /// Removes `TARGET.part`. Nothing may be called after it.
  void abandon();

 private:
  struct State;
  explicit PackWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
