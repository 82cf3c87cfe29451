#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace cairn::test {

/// The folder of real DEMs and imagery: $CAIRN_DATA, else ../shared/data beside the repository.
/// Without it, returns nullopt and says SKIPPED, by which ctest shows the calling test as skipped:
/// `if (!data) return;`. Such a test has the tag [data].
std::optional<std::filesystem::path> real_data();

/// The repository's own sample-dem/ folder; always present.
std::filesystem::path sample_dem();

/// A fresh empty directory for one test, removed with everything in it when the object goes.
class TempDir {
 public:
  TempDir();
  ~TempDir();
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cairn::test
