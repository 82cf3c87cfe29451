#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// A folder of files that an export makes: written as `TARGET.part` and renamed when whole. A journal in it
/// says which tasks are done, so that an interrupted export can go on.
class ExportFolder {
 public:
  /// `identity` is a line that tells this export from others: the pack and all options that decide a byte.
  /// With `resume`, goes on with work of the same identity, where there is some. usage where the target
  /// exists, or TARGET.part does and is not to be resumed or another export's.
  static Result<ExportFolder> begin(const std::filesystem::path& target, const std::string& identity,
                                    bool resume);

  /// The lines that append() wrote before an interruption.
  const std::vector<std::string>& done() const { return done_; }

  /// Writes a file by its name relative to the folder. Any number of threads may write different files.
  Status write(const std::filesystem::path& name, std::span<const std::byte> bytes) const;
  Status write(const std::filesystem::path& name, const std::string& text) const;

  /// Notes that a task is done, in one line without a line break.
  Status append(const std::string& line);

  /// Where the files are written.
  const std::filesystem::path& path() const { return part_; }

  /// Removes the journal and gives the folder its name.
  Status finish();

  /// Gives one of the files the target's name and removes the folder with all else in it.
  Status finish_as_file(const std::filesystem::path& name);

  /// Removes the folder with all in it: nothing of it can be gone on from.
  void discard();

 private:
  ExportFolder(std::filesystem::path target, std::filesystem::path part, File journal)
      : target_(std::move(target)), part_(std::move(part)), journal_(std::move(journal)) {}

  std::filesystem::path target_;
  std::filesystem::path part_;
  File journal_;
  std::uint64_t end_ = 0;
  std::vector<std::string> done_;
};

}  // namespace cairn
