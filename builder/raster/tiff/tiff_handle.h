#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cairn/status.h"

struct tiff;

namespace cairn {

/// libtiff's handle on one directory of a file, silent, with its last complaint kept. One thread at a time.
class TiffHandle {
 public:
  static Result<std::unique_ptr<TiffHandle>> open(const std::filesystem::path& path, std::uint16_t directory);
  ~TiffHandle();
  TiffHandle(const TiffHandle&) = delete;
  TiffHandle& operator=(const TiffHandle&) = delete;

  ::tiff* get() const { return tiff_; }
  /// libtiff's last complaint, or "damaged data".
  std::string reason() const { return complaint_.empty() ? "damaged data" : complaint_; }
  void note(std::string complaint) { complaint_ = std::move(complaint); }

  /// A tag's values, where the tag is there and of that type, whoever registered it with libtiff.
  std::vector<double> doubles(std::uint32_t tag) const;
  std::vector<std::uint16_t> shorts(std::uint32_t tag) const;
  std::string ascii(std::uint32_t tag) const;

 private:
  TiffHandle() = default;
  ::tiff* tiff_ = nullptr;
  std::string complaint_;
};

/// Handles on one directory of one file, as many as threads have wanted at once.
class TiffHandlePool {
 public:
  TiffHandlePool(std::filesystem::path path, std::uint16_t directory)
      : path_(std::move(path)), directory_(directory) {}

  /// Takes a handle; give it back when done.
  Result<std::unique_ptr<TiffHandle>> take();
  void give_back(std::unique_ptr<TiffHandle> handle);

 private:
  std::filesystem::path path_;
  std::uint16_t directory_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<TiffHandle>> idle_;
};

}  // namespace cairn
