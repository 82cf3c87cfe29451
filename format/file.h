#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "cairn/status.h"

namespace cairn {

/// An open file: positioned, exact reads and writes, and errors in one line that names the file. Reads may
/// run in any number of threads at once; everything else belongs to one thread at a time.
class File {
 public:
  /// Opens an existing file for reading.
  static Result<File> open_to_read(const std::filesystem::path& path);

  /// Opens a file for reading and writing, made if it is not there, and locks it against every other
  /// process that would open it so. What it holds stays until truncate(). `failed` where another process
  /// has it.
  static Result<File> open_to_write(const std::filesystem::path& path);

  /// Opens a file of this process in the folder, for reading and writing, which has no name: its bytes are
  /// freed when it is closed, however the process ends.
  static Result<File> open_scratch(const std::filesystem::path& folder);

  File(File&& other) noexcept : handle_(std::exchange(other.handle_, -1)), path_(std::move(other.path_)) {}
  File& operator=(File&& other) noexcept {
    std::swap(handle_, other.handle_);
    std::swap(path_, other.path_);
    return *this;
  }
  ~File();

  const std::filesystem::path& path() const { return path_; }
  Result<std::uint64_t> size() const;

  /// Fills `bytes` from `offset` on; bad_data where the file ends before.
  Status read(std::uint64_t offset, std::span<std::byte> bytes) const;

  Status write(std::uint64_t offset, std::span<const std::byte> bytes);
  Status truncate(std::uint64_t size);

  /// Asks the system to begin putting these bytes on the disk: sync() then has less to wait for.
  void start_sync(std::uint64_t offset, std::uint64_t bytes);
  /// Returns when everything written is on the disk.
  Status sync();

 private:
  File(std::intptr_t handle, std::filesystem::path path) : handle_(handle), path_(std::move(path)) {}

  std::intptr_t handle_ = -1;  // a descriptor of POSIX, or a HANDLE of Windows
  std::filesystem::path path_;
};

/// Gives `from` the name `to`, replacing what was there, and returns when the folder's entry is on the disk.
Status rename_durably(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace cairn
