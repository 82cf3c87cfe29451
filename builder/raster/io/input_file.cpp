#include "builder/raster/io/input_file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cairn {

Result<InputFile> InputFile::open(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0)
    return bad_data(path.string() + ": expected a readable file, found: " + std::strerror(errno));
  InputFile file(descriptor, path, 0);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return failed(path.string() + ": " + std::strerror(errno));
  if (!S_ISREG(status.st_mode))
    return bad_data(path.string() + ": expected a regular file, found something else");
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  std::swap(size_, other.size_);
  return *this;
}

Status InputFile::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got =
        ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      return failed(path_.string() + ": byte " + std::to_string(offset + done) + ": " + std::strerror(errno));
    if (got == 0)
      return bad_data(path_.string() + ": byte " + std::to_string(offset) + ": expected " +
                      std::to_string(out.size()) + " bytes, found the file's end after " +
                      std::to_string(done));
    done += static_cast<std::size_t>(got);
  }
  return {};
}

}  // namespace cairn
