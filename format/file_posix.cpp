#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "format/file.h"

namespace cairn {
namespace {

constexpr std::size_t kLargestTransfer = std::size_t{1} << 30;  // Linux moves less than 2 GiB a call

Error os_error(const std::filesystem::path& path, const std::string& doing) {
  return failed(path.string() + ": " + doing + ": " + std::strerror(errno));
}

Result<int> open_descriptor(const std::filesystem::path& path, int flags, const char* doing) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
    if (descriptor >= 0) return descriptor;
    if (errno != EINTR) return os_error(path, doing);
  }
}

Status sync_folder(const std::filesystem::path& folder) {
  const Result<int> descriptor = open_descriptor(folder, O_RDONLY | O_DIRECTORY, "open folder");
  if (!descriptor) return descriptor.error();
  const int result = ::fsync(*descriptor);
  // Some network and FUSE file systems cannot sync a folder; the rename itself has been done.
  const bool failure = result != 0 && errno != EINVAL && errno != ENOTSUP;
  const Status status = failure ? Status(os_error(folder, "sync folder")) : Status();
  ::close(*descriptor);
  return status;
}

}  // namespace

Result<File> File::open_to_read(const std::filesystem::path& path) {
  const Result<int> descriptor = open_descriptor(path, O_RDONLY | O_NONBLOCK, "open");  // a FIFO would block
  if (!descriptor) return descriptor.error();
  File file(*descriptor, path);
  struct stat info {};
  if (::fstat(*descriptor, &info) != 0) return os_error(path, "stat");
  if (!S_ISREG(info.st_mode)) return bad_data(path.string() + ": expected a regular file");
  return file;
}

Result<File> File::open_to_write(const std::filesystem::path& path) {
  const Result<int> descriptor = open_descriptor(path, O_RDWR | O_CREAT, "create");
  if (!descriptor) return descriptor.error();
  File file(*descriptor, path);
  if (::flock(*descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return failed(path.string() + ": another process is writing it");
  }
  return file;
}

// Not every file system has files without a name; elsewhere the name is taken away at once.
Result<File> File::open_scratch(const std::filesystem::path& folder) {
  const std::filesystem::path where = folder.empty() ? std::filesystem::path(".") : folder;
  const int nameless = ::open(where.c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC, 0600);
  if (nameless >= 0) return File(nameless, where / "scratch file");
  std::string name = (where / "cairn-scratch-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) return os_error(name, "create");
  File file(named, name);
  if (::unlink(name.c_str()) != 0) return os_error(name, "unlink");
  return file;
}

namespace {

int descriptor_of(std::intptr_t handle) {
  return static_cast<int>(handle);
}

}  // namespace

File::~File() {
  if (handle_ >= 0) ::close(descriptor_of(handle_));
}

Result<std::uint64_t> File::size() const {
  struct stat info {};
  if (::fstat(descriptor_of(handle_), &info) != 0) return os_error(path_, "stat");
  return static_cast<std::uint64_t>(info.st_size);
}

Status File::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::size_t wanted = std::min(bytes.size() - done, kLargestTransfer);
    const ssize_t got =
        ::pread(descriptor_of(handle_), bytes.data() + done, wanted, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return os_error(path_, "read at " + std::to_string(offset + done));
    if (got == 0) {
      return bad_data(path_.string() + ": byte " + std::to_string(offset) + ": expected " +
                      std::to_string(bytes.size()) + " bytes, found " + std::to_string(done));
    }
    done += static_cast<std::size_t>(got);
  }
  return {};
}

Status File::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::size_t wanted = std::min(bytes.size() - done, kLargestTransfer);
    const ssize_t put =
        ::pwrite(descriptor_of(handle_), bytes.data() + done, wanted, static_cast<off_t>(offset + done));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return os_error(path_, "write at " + std::to_string(offset + done));
    done += static_cast<std::size_t>(put);
  }
  return {};
}

Status File::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_of(handle_), static_cast<off_t>(size)) != 0) return os_error(path_, "truncate");
  return {};
}

void File::start_sync(std::uint64_t offset, std::uint64_t bytes) {
  // A hint: what goes wrong with the bytes shows in sync().
  (void)::sync_file_range(descriptor_of(handle_), static_cast<off_t>(offset), static_cast<off_t>(bytes),
                          SYNC_FILE_RANGE_WRITE);
}

Status File::sync() {
  if (::fsync(descriptor_of(handle_)) != 0) return os_error(path_, "sync");
  return {};
}

Status rename_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return os_error(from, "rename to " + to.string());
  const std::filesystem::path folder = to.parent_path();
  return sync_folder(folder.empty() ? std::filesystem::path(".") : folder);
}

}  // namespace cairn
