#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/pack_layout.h"

namespace cairn {

/// Parts of packs on the disk, each in a file of its own, whose name is the pack's id and where the part
/// lies. A part that cannot be read or written is as if it were not there. Any number of threads, and of
/// processes on one folder.
class DiskCache {
 public:
  /// Keeps at most so many bytes in all: those that were used latest.
  DiskCache(std::filesystem::path folder, std::uint64_t most_bytes, const PackId& pack);

  /// Returns whether the part was there; fills `out` with it.
  bool read(std::uint64_t offset, std::span<std::byte> out) const;
  bool has(ByteRange part) const;
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  void remove(ByteRange part);

 private:
  std::filesystem::path file_of(ByteRange part) const;
  void make_room();

  std::filesystem::path folder_;
  std::filesystem::path own_folder_;
  std::uint64_t most_bytes_;
  std::mutex mutex_;
  std::optional<std::uint64_t> bytes_;  // in the folder, as far as this process knows; guarded by mutex_
};

}  // namespace cairn
