#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "builder/raster/io/input_file.h"
#include "cairn/status.h"

namespace cairn {

/// Bytes written once from front to back and then read anywhere, for files that cannot be read in the middle
/// (gzip, JPEG, one giant strip): held in memory up to a limit, past it in an unlinked temporary file in
/// $TMPDIR.
class ScratchBytes {
 public:
  explicit ScratchBytes(std::size_t memory_limit) : memory_limit_(memory_limit) {}

  /// failed where the temporary file cannot be written. Not for several threads at once.
  Status append(std::span<const std::byte> bytes);

  /// REQUIRES: the bytes were written. Safe from several threads once writing is over.
  Status read_at(std::uint64_t offset, std::span<std::byte> out) const;

  std::uint64_t size() const { return size_; }

 private:
  Status move_to_file();
  Status write(std::span<const std::byte> bytes);

  std::size_t memory_limit_;
  std::uint64_t size_ = 0;
  std::vector<std::byte> memory_;
  std::optional<InputFile> file_;
  int descriptor_ = -1;  // file_'s, which owns it
};

}  // namespace cairn
