// File on Windows. It is compiled with mingw-w64 and has not been run (docs/platforms.md).

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

#include "format/file.h"

namespace cairn {
namespace {

constexpr std::size_t kLargestTransfer = std::size_t{1} << 30;  // a transfer's length is a 32-bit number

Error os_error(const std::filesystem::path& path, const std::string& doing) {
  const int code = static_cast<int>(::GetLastError());
  return failed(path.string() + ": " + doing + ": " + std::system_category().message(code));
}

HANDLE handle_of(std::intptr_t handle) {
  return reinterpret_cast<HANDLE>(handle);
}

std::intptr_t number_of(HANDLE handle) {
  return reinterpret_cast<std::intptr_t>(handle);
}

/// Where a transfer begins: a HANDLE's own position is not touched, so that reads may run side by side.
OVERLAPPED at(std::uint64_t offset) {
  OVERLAPPED place{};
  place.Offset = static_cast<DWORD>(offset);
  place.OffsetHigh = static_cast<DWORD>(offset >> 32);
  return place;
}

DWORD transfer_bytes(std::size_t left) {
  return static_cast<DWORD>(std::min(left, kLargestTransfer));
}

constexpr DWORD kShareAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

}  // namespace

Result<File> File::open_to_read(const std::filesystem::path& path) {
  const HANDLE handle = ::CreateFileW(path.c_str(), GENERIC_READ, kShareAll, nullptr, OPEN_EXISTING,
                                      FILE_ATTRIBUTE_NORMAL | FILE_FLAG_RANDOM_ACCESS, nullptr);
  if (handle == INVALID_HANDLE_VALUE) return os_error(path, "open");
  File file(number_of(handle), path);
  if (::GetFileType(handle) != FILE_TYPE_DISK) return bad_data(path.string() + ": expected a regular file");
  return file;
}

Result<File> File::open_to_write(const std::filesystem::path& path) {
  // Others may read it and rename it, but not open it to write.
  const HANDLE handle =
      ::CreateFileW(path.c_str(), GENERIC_READ | GENERIC_WRITE | DELETE, FILE_SHARE_READ | FILE_SHARE_DELETE,
                    nullptr, OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE && ::GetLastError() == ERROR_SHARING_VIOLATION)
    return failed(path.string() + ": another process is writing it");
  if (handle == INVALID_HANDLE_VALUE) return os_error(path, "create");
  return File(number_of(handle), path);
}

Result<File> File::open_scratch(const std::filesystem::path& folder) {
  const std::filesystem::path where = folder.empty() ? std::filesystem::path(".") : folder;
  wchar_t name[MAX_PATH + 1];
  if (::GetTempFileNameW(where.c_str(), L"crn", 0, name) == 0) return os_error(where, "create scratch file");
  const HANDLE handle =
      ::CreateFileW(name, GENERIC_READ | GENERIC_WRITE | DELETE, FILE_SHARE_DELETE, nullptr, CREATE_ALWAYS,
                    FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
  if (handle == INVALID_HANDLE_VALUE) return os_error(name, "create");
  return File(number_of(handle), name);
}

File::~File() {
  if (handle_ != -1) ::CloseHandle(handle_of(handle_));
}

Result<std::uint64_t> File::size() const {
  LARGE_INTEGER size;
  if (::GetFileSizeEx(handle_of(handle_), &size) == 0) return os_error(path_, "size");
  return static_cast<std::uint64_t>(size.QuadPart);
}

Status File::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    OVERLAPPED place = at(offset + done);
    DWORD got = 0;
    const BOOL read = ::ReadFile(handle_of(handle_), bytes.data() + done, transfer_bytes(bytes.size() - done),
                                 &got, &place);
    if (read == 0 && ::GetLastError() != ERROR_HANDLE_EOF)
      return os_error(path_, "read at " + std::to_string(offset + done));
    if (got == 0) {
      return bad_data(path_.string() + ": byte " + std::to_string(offset) + ": expected " +
                      std::to_string(bytes.size()) + " bytes, found " + std::to_string(done));
    }
    done += got;
  }
  return {};
}

Status File::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    OVERLAPPED place = at(offset + done);
    DWORD put = 0;
    if (::WriteFile(handle_of(handle_), bytes.data() + done, transfer_bytes(bytes.size() - done), &put,
                    &place) == 0)
      return os_error(path_, "write at " + std::to_string(offset + done));
    done += put;
  }
  return {};
}

Status File::truncate(std::uint64_t size) {
  FILE_END_OF_FILE_INFO end;
  end.EndOfFile.QuadPart = static_cast<LONGLONG>(size);
  if (::SetFileInformationByHandle(handle_of(handle_), FileEndOfFileInfo, &end, sizeof end) == 0)
    return os_error(path_, "truncate");
  return {};
}

void File::start_sync(std::uint64_t, std::uint64_t) {}  // Windows has no such hint

Status File::sync() {
  if (::FlushFileBuffers(handle_of(handle_)) == 0) return os_error(path_, "sync");
  return {};
}

Status rename_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) == 0)
    return os_error(from, "rename to " + to.string());
  return {};
}

}  // namespace cairn
