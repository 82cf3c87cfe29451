#include "format/gdal/vsi_source.h"

#include <filesystem>
#include <mutex>
#include <utility>

#include <cpl_error.h>
#include <cpl_vsi.h>

namespace cairn {
namespace {

class VsiSource final : public ByteSource {
 public:
  VsiSource(std::filesystem::path name, VSILFILE* file, std::uint64_t size)
      : name_(std::move(name)), file_(file), size_(size) {}
  ~VsiSource() override { VSIFCloseL(file_); }

  const std::filesystem::path& name() const override { return name_; }
  Result<std::uint64_t> size() const override { return size_; }
  bool is_slow() const override { return true; }

  using ByteSource::read;
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > size_ || out.size() > size_ - offset)
      return bad_data(name_.string() + ": expected " + std::to_string(out.size()) + " bytes at " +
                      std::to_string(offset) + ", found the end at " + std::to_string(size_));
    const std::lock_guard lock(mutex_);
    if (VSIFSeekL(file_, offset, SEEK_SET) == 0 && VSIFReadL(out.data(), 1, out.size(), file_) == out.size())
      return {};
    return failed(name_.string() + ": " + std::to_string(out.size()) + " bytes at " + std::to_string(offset) +
                  " could not be read");
  }

 private:
  std::filesystem::path name_;
  mutable std::mutex mutex_;
  VSILFILE* file_;  // one call at a time, under the mutex
  std::uint64_t size_;
};

}  // namespace

Result<std::unique_ptr<const ByteSource>> open_vsi_source(const std::string& file) {
  VSIStatBufL status;
  if (VSIStatL(file.c_str(), &status) != 0) return failed(file + ": no such file, or no answer");
  VSILFILE* opened = VSIFOpenL(file.c_str(), "rb");
  if (opened == nullptr) return failed(file + ": cannot be opened");
  return std::unique_ptr<const ByteSource>(
      std::make_unique<VsiSource>(file, opened, static_cast<std::uint64_t>(status.st_size)));
}

}  // namespace cairn
