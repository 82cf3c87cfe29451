#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/status.h"
#include "format/file.h"

namespace cairn {

/// Entries of an index that come in any order and go out sorted, in memory that does not grow with their
/// number: sorted runs of them lie in a scratch file, which has no name and is gone with the process.
class EntryStore {
 public:
  /// The scratch file is made in `folder` when it is needed.
  explicit EntryStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  Status add(const IndexEntry& entry);

  /// Calls `visit` with each entry, in the order of the index; equal keys follow each other. Ends at the
  /// first error.
  Status visit(const std::function<Status(const IndexEntry&)>& visit) const;

 private:
  struct Run {
    std::uint64_t offset = 0;
    std::uint64_t entries = 0;
  };
  class RunReader;

  Status write_run();

  std::filesystem::path folder_;
  std::optional<File> scratch_;
  std::uint64_t scratch_bytes_ = 0;
  std::vector<Run> runs_;
  std::vector<IndexEntry> latest_;
};

}  // namespace cairn
