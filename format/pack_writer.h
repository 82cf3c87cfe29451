#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// Writes one pack beside its target, as `TARGET.part`, and renames it when it is whole: a reader never sees
/// half a pack. The part is locked against other processes. One thread at a time. After an error of add(),
/// flush() or finish() only abandon() or the destructor may follow.
class PackWriter {
 public:
  /// Starts `TARGET.part` anew. Fails where the folder cannot be written.
  static Result<PackWriter> create(const std::filesystem::path& target, const PackHeader& header);

  /// Goes on with an existing `TARGET.part` of which the blocks of `entries` are known to be good, in the
  /// order in which they were added: everything after the last of them is cut off. bad_data where the part
  /// is shorter than they say; whether the blocks are whole (their checksums) is for the caller to know.
  static Result<PackWriter> reopen(const std::filesystem::path& target, const PackHeader& header,
                                   std::span<const IndexEntry> entries);

  PackWriter(PackWriter&&) noexcept;
  PackWriter& operator=(PackWriter&&) noexcept;
  ~PackWriter();  ///< closes; leaves `TARGET.part` as it is

  /// Appends a block and its entry; offset, bytes and checksum of the entry are filled in here and returned.
  /// An equal block that is already there is shared, not written again. REQUIRES: the block is empty where
  /// the entry has kConstant, and only there; each tile is added once.
  Result<IndexEntry> add(IndexEntry entry, std::span<const std::byte> block);

  /// Bytes of blocks so far, header included.
  std::uint64_t position() const;

  /// All entries so far, in the order of add().
  const std::vector<IndexEntry>& entries() const;

  /// The block of an entry that add() returned, checked by its checksum. REQUIRES: flush() since then. Any
  /// thread, while another one adds.
  Result<std::vector<std::byte>> read_block(const IndexEntry& entry) const;

  /// Hands all blocks so far to the file: they outlive a killed process (but not a power cut).
  Status flush();

  /// Writes index, metadata and header, syncs, renames to the target. The writer is done after it.
  Status finish(std::string_view metadata_json);

  /// Removes `TARGET.part`. The writer is done after it.
  void abandon();

 private:
  struct State;
  explicit PackWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
