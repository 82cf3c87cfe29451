#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// What one task of a bake added to the pack.
struct UnitRecord {
  std::vector<IndexEntry> entries;  ///< in the order in which they were added
  std::vector<std::byte> root;  ///< of the unit's subtree, as its layer writes it; empty as read() gives it
  std::uint64_t start = 0;      ///< of the record in its journal
  std::uint64_t end = 0;
};

/// The record of a bake that is under way, `TARGET.journal`: one checked record a unit, so that an
/// interrupted bake can go on after the last one. Removed when the pack is whole.
class Journal {
 public:
  /// The first bytes of a journal that is identified.
  static constexpr std::array<char, 8> kMagic = {'C', 'A', 'I', 'R', 'N', 'J', 'N', '2'};

  /// The file's name for a target.
  static std::filesystem::path path_for(const std::filesystem::path& target);

  /// Starts anew. Nothing can be read back before identify().
  static Result<Journal> create(const std::filesystem::path& target);

  /// Says whose records these are. `fingerprint` stands for the inputs and options: records of another bake
  /// are never mixed in. Other threads may append() meanwhile.
  Status identify(std::uint64_t fingerprint);

  /// Goes on after the last of these records; everything after it is cut off. REQUIRES: not empty, from
  /// read().
  static Result<Journal> reopen(const std::filesystem::path& target, const std::vector<UnitRecord>& records);

  /// The fingerprint of an interrupted bake that has work to go on from; nullopt where there is no journal,
  /// it was not identified, or it holds no record.
  static std::optional<std::uint64_t> fingerprint_of(const std::filesystem::path& target);

  /// The records of an interrupted bake with this fingerprint, up to the first that is not whole, without
  /// their roots: those of a large bake would fill the memory. Empty where there is no journal or it belongs
  /// to another bake.
  static std::vector<UnitRecord> read(const std::filesystem::path& target, std::uint64_t fingerprint);

  /// The root of such a record.
  Result<std::vector<std::byte>> read_root(const UnitRecord& record) const;

  Status append(const UnitRecord& record);

  /// Returns whether it holds no record yet.
  bool is_empty() const;

 private:
  explicit Journal(File file) : file_(std::move(file)) {}
  File file_;
  std::uint64_t end_ = 0;
};

}  // namespace cairn
