#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "cairn/status.h"

namespace cairn {

/// A file open for reading at any offset, by any number of threads at once.
class InputFile {
 public:
  static Result<InputFile> open(const std::filesystem::path& path);
  /// Takes over an open descriptor, e.g. of an unlinked temporary file; the path is for messages.
  InputFile(int descriptor, std::filesystem::path path, std::uint64_t size)
      : descriptor_(descriptor), path_(std::move(path)), size_(size) {}
  ~InputFile();
  InputFile(InputFile&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)),
        path_(std::move(other.path_)),
        size_(other.size_) {}
  InputFile& operator=(InputFile&& other) noexcept;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Fills `out`. bad_data where the file ends too early; failed where the machine cannot read.
  Status read_at(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  int descriptor_;
  std::filesystem::path path_;
  std::uint64_t size_;
};

}  // namespace cairn
