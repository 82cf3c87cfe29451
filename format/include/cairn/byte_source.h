#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "cairn/status.h"

namespace cairn {

/// A range of a file.
struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// The bytes of one pack, wherever it lies: PackReader reads through it. Any number of threads may call it at
/// once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// The file's name or address, with which each error message begins.
  virtual const std::filesystem::path& name() const = 0;

  virtual Result<std::uint64_t> size() const = 0;

  /// Fills `out` from `offset` on. bad_data where the file ends before, `failed` where it cannot be read.
  virtual Status read(std::uint64_t offset, std::span<std::byte> out) const = 0;

  /// Whether a read takes as long as a journey through a network. PackReader then reads the metadata when it
  /// is asked for, and says what lies beside a block.
  virtual bool is_slow() const { return false; }

  /// The same as read(), and says which other ranges are likely to be read next. A slow source may fetch them
  /// in one go.
  virtual Status read(std::uint64_t offset, std::span<std::byte> out,
                      std::span<const ByteRange> likely_next) const {
    (void)likely_next;
    return read(offset, out);
  }

  /// Called after a read whose bytes had another checksum than the pack states. Returns whether another read
  /// may give other bytes: the source has forgotten its copy. An error says that the file is another one now.
  virtual Result<bool> recheck(ByteRange range) const {
    (void)range;
    return false;
  }
};

}  // namespace cairn
