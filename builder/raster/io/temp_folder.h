#pragma once

#include <filesystem>
#include <utility>

#include "cairn/status.h"

namespace cairn {

/// A new folder in $TMPDIR, removed with all that is in it when its owner is. One that a killed process
/// leaves is called `cairn-unpacked-…`.
class TempFolder {
 public:
  static Result<TempFolder> make();
  ~TempFolder();
  TempFolder(TempFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TempFolder& operator=(TempFolder&& other) noexcept;

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TempFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace cairn
