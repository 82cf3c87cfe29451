#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "builder/bake/journal.h"
#include "builder/shard/part_record.h"
#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// Whose tiles a part holds.
struct PartDescription {
  std::string version;      ///< of the program that made it
  std::uint64_t key = 0;    ///< the shard's, see Shard
  std::size_t shard = 0;    ///< by number in the plan
  std::size_t shards = 0;   ///< of the plan
  std::uint64_t units = 0;  ///< records that follow

  friend bool operator==(const PartDescription&, const PartDescription&) = default;
};

/// A part under way. It is its own journal: TARGET.journal holds a checked record for each unit that is done,
/// and becomes TARGET once all are.
class PartWriter {
 public:
  /// With `session.resume`, goes on after the last whole record of an interrupted part of this description;
  /// else starts anew. Work of another description is wrong usage, unless `session.force` is set.
  static Result<PartWriter> begin(const SessionOptions& session, const PartDescription& description);

  /// The records of an interrupted part, in the order of append().
  std::size_t done() const { return done_.size(); }
  Result<PartRecord> read_done(std::size_t number) const;

  Status append(const PartRecord& record);
  std::uint64_t bytes() const { return bytes_; }

  /// Nothing may be called after it. REQUIRES: as many records as the description says.
  Status finish();

 private:
  PartWriter(std::filesystem::path target, Journal journal)
      : target_(std::move(target)), journal_(std::move(journal)) {}

  std::filesystem::path target_;
  Journal journal_;
  std::vector<RecordPlace> done_;
  std::uint64_t bytes_ = 0;
};

/// A finished part, read from its beginning to its end.
class PartReader {
 public:
  /// The error is bad_data where the file is no part.
  static Result<PartReader> open(const std::filesystem::path& path);

  /// open(), to go on with the record at `position`, where another reader of it was.
  static Result<PartReader> open_at(const std::filesystem::path& path, std::uint64_t position);

  const std::filesystem::path& path() const { return path_; }
  const PartDescription& description() const { return description_; }
  std::uint64_t bytes() const { return journal_.bytes(); }
  std::uint64_t position() const { return journal_.position(); }

  /// The next unit; the error is bad_data where the part ends before or is damaged.
  Result<PartRecord> next();

  /// The error is bad_data where more follows.
  Status check_end();

 private:
  PartReader(std::filesystem::path path, JournalReader journal)
      : path_(std::move(path)), journal_(std::move(journal)) {}

  std::filesystem::path path_;
  JournalReader journal_;
  PartDescription description_;
};

}  // namespace cairn
