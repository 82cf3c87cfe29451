#include "builder/raster/io/scratch_bytes.h"

#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include <stdlib.h>
#include <unistd.h>

namespace cairn {

Status ScratchBytes::append(std::span<const std::byte> bytes) {
  if (!file_ && bytes.size() > memory_limit_ - memory_.size()) {
    if (auto moved = move_to_file(); !moved) return moved;
  }
  if (file_) {
    if (auto written = write(bytes); !written) return written;
  } else {
    memory_.insert(memory_.end(), bytes.begin(), bytes.end());
  }
  size_ += bytes.size();
  return {};
}

Status ScratchBytes::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  assert(offset + out.size() <= size_);
  if (file_) return file_->read_at(offset, out);
  std::memcpy(out.data(), memory_.data() + offset, out.size());
  return {};
}

Status ScratchBytes::move_to_file() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "cairn-scratch-XXXXXX").string();
  const int descriptor = ::mkstemp(name.data());
  if (descriptor < 0) return failed(name + ": cannot make a temporary file: " + std::strerror(errno));
  ::unlink(name.c_str());
  file_.emplace(descriptor, name, 0);
  descriptor_ = descriptor;
  if (auto written = write(memory_); !written) return written;
  memory_ = {};
  return {};
}

Status ScratchBytes::write(std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t put = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return failed(file_->path().string() + ": temporary file: " + std::strerror(errno));
    done += static_cast<std::size_t>(put);
  }
  return {};
}

}  // namespace cairn
