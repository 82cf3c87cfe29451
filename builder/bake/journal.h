#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "builder/bake/tile_layer.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// What one task of a bake added to the pack.
struct UnitRecord {
  std::vector<IndexEntry> entries;  ///< in the order in which they were added
  std::optional<TileBlock> held;    ///< the unit's own tile, which is written together with its siblings
  std::vector<std::byte> root;      ///< of the unit's subtree, as its layer writes it
};

/// Where a record lies in its journal.
struct RecordPlace {
  std::uint64_t start = 0;
  std::uint64_t end = 0;
};

/// The record of a bake that is under way, `TARGET.journal`: one checked record a unit, so that an
/// interrupted bake can go on after the last one. Removed when the pack is whole.
class Journal {
 public:
  /// The first bytes of a journal that is identified.
  static constexpr std::array<char, 8> kMagic = {'C', 'A', 'I', 'R', 'N', 'J', 'N', '3'};

  /// The file's name for a target.
  static std::filesystem::path path_for(const std::filesystem::path& target);

  /// Starts anew. Nothing can be read back before identify().
  static Result<Journal> create(const std::filesystem::path& target);

  /// Says whose records these are. `fingerprint` stands for the inputs and options: records of another bake
  /// are never mixed in. Other threads may append() meanwhile.
  Status identify(std::uint64_t fingerprint);

  /// Goes on after the last of these records; everything after it is cut off. REQUIRES: not empty, from
  /// find_records().
  static Result<Journal> reopen(const std::filesystem::path& target, const std::vector<RecordPlace>& records);

  /// The fingerprint of an interrupted bake that has work to go on from; nullopt where there is no journal,
  /// it was not identified, or it holds no record.
  static std::optional<std::uint64_t> fingerprint_of(const std::filesystem::path& target);

  /// Returns where the records of an interrupted bake with this fingerprint lie, up to the first that is not
  /// whole or that `is_good` refuses. Returns none if there is no journal or it belongs to another bake.
  static std::vector<RecordPlace> find_records(const std::filesystem::path& target, std::uint64_t fingerprint,
                                               const std::function<bool(const UnitRecord&)>& is_good);

  /// Reads such a record. The error is bad_data if it has changed meanwhile.
  Result<UnitRecord> read(const RecordPlace& place) const;

  Status append(const UnitRecord& record);

  /// Returns whether it holds no record yet.
  bool is_empty() const;

  /// Gives the journal another name, once it is on the disk: it becomes a file of its own. Nothing may be
  /// called after it.
  Status keep_as(const std::filesystem::path& name);

 private:
  explicit Journal(File file) : file_(std::move(file)) {}
  File file_;
  std::uint64_t end_ = 0;
};

/// Reads the records of a journal that was kept, one after the other.
class JournalReader {
 public:
  /// The error is bad_data where the file is no journal, or was never identified.
  static Result<JournalReader> open(const std::filesystem::path& path);

  std::uint64_t fingerprint() const { return fingerprint_; }
  std::uint64_t bytes() const { return size_; }
  std::uint64_t position() const { return at_; }
  /// REQUIRES: position() was that before next(), of any reader of the file.
  void go_to(std::uint64_t position) { at_ = position; }

  /// Returns nullopt at the end. The error is bad_data where a record is damaged or not whole.
  Result<std::optional<UnitRecord>> next();

  /// Reads a record again. The error is bad_data where it is damaged.
  Result<UnitRecord> read(const RecordPlace& place) const;

 private:
  JournalReader(File file, std::uint64_t fingerprint, std::uint64_t size);
  File file_;
  std::uint64_t fingerprint_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;
};

}  // namespace cairn
