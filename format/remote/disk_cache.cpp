#include "format/remote/disk_cache.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <system_error>

#include <unistd.h>

#include "format/checksum.h"
#include "format/file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSumBytes = sizeof(std::uint64_t);  // a checksum comes before the part

struct CachedFile {
  fs::file_time_type used;
  std::uint64_t bytes = 0;
  fs::path path;
};

std::vector<CachedFile> files_in(const fs::path& folder) {
  std::vector<CachedFile> files;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    if (!it->is_regular_file(gone)) continue;
    const auto bytes = it->file_size(gone);
    const auto used = it->last_write_time(gone);
    if (!gone) files.push_back({used, bytes, it->path()});
  }
  return files;
}

}  // namespace

DiskCache::DiskCache(fs::path folder, std::uint64_t most_bytes, const PackId& pack)
    : folder_(std::move(folder)), own_folder_(folder_ / to_string(pack)), most_bytes_(most_bytes) {}

fs::path DiskCache::file_of(ByteRange part) const {
  return own_folder_ / (std::to_string(part.offset) + "-" + std::to_string(part.bytes));
}

bool DiskCache::has(ByteRange part) const {
  std::error_code error;
  return fs::exists(file_of(part), error);
}

bool DiskCache::read(std::uint64_t offset, std::span<std::byte> out) const {
  const fs::path path = file_of({offset, out.size()});
  const auto file = File::open_to_read(path);
  if (!file) return false;
  std::uint64_t sum = 0;
  if (!file->read(0, std::as_writable_bytes(std::span(&sum, 1))) || !file->read(kSumBytes, out)) return false;
  if (checksum(out) != sum) return false;
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  return true;
}

// Written under another name first, so that a reader never finds half a part.
void DiskCache::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  static std::atomic<unsigned> number = 0;
  if (bytes.size() + kSumBytes > most_bytes_) return;
  std::error_code error;
  fs::create_directories(own_folder_, error);
  const fs::path path = file_of({offset, bytes.size()});
  const fs::path part = own_folder_ / ("part-" + std::to_string(::getpid()) + "-" + std::to_string(number++));
  bool is_written = false;
  if (auto file = File::open_to_write(part)) {
    const std::uint64_t sum = checksum(bytes);
    is_written = file->write(0, std::as_bytes(std::span(&sum, 1))).ok() && file->write(kSumBytes, bytes).ok();
  }
  if (is_written) fs::rename(part, path, error);
  if (!is_written || error) {
    fs::remove(part, error);
    return;
  }
  const std::lock_guard lock(mutex_);
  if (bytes_) *bytes_ += bytes.size() + kSumBytes;
  if (!bytes_ || *bytes_ > most_bytes_) make_room();
}

void DiskCache::remove(ByteRange part) {
  std::error_code ignored;
  fs::remove(file_of(part), ignored);
}

// A tenth more than is needed goes, so that the folder is not listed for each part.
void DiskCache::make_room() {
  std::vector<CachedFile> files = files_in(folder_);
  std::uint64_t bytes = 0;
  for (const CachedFile& file : files) bytes += file.bytes;
  if (bytes > most_bytes_) {
    std::sort(files.begin(), files.end(),
              [](const CachedFile& a, const CachedFile& b) { return a.used < b.used; });
    for (const CachedFile& file : files) {
      if (bytes <= most_bytes_ - most_bytes_ / 10) break;
      std::error_code error;
      if (fs::remove(file.path, error)) bytes -= file.bytes;
    }
  }
  bytes_ = bytes;
}

}  // namespace cairn
