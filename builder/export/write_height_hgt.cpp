#include <system_error>
#include <vector>

#include "builder/export/height_image.h"
#include "builder/export/whole_metres.h"
#include "format/file.h"

namespace cairn {
namespace {

Status write_part(const std::filesystem::path& part, std::span<const std::byte> bytes) {
  Result<File> file = File::open_to_write(part);
  if (!file) return file.error();
  Status status = file->truncate(0);
  if (status) status = file->write(0, bytes);
  if (status) status = file->sync();
  return status;
}

}  // namespace

Status write_height_hgt(const std::filesystem::path& path, const HeightImage& image) {
  std::vector<std::byte> bytes;
  bytes.reserve(2 * image.metres.size());
  for (const double metres : image.metres) {
    const auto value = static_cast<std::uint16_t>(whole_metres(metres));
    bytes.push_back(static_cast<std::byte>(value >> 8));
    bytes.push_back(static_cast<std::byte>(value & 0xFF));
  }
  const std::filesystem::path part = path.string() + ".part";
  Status status = write_part(part, bytes);
  if (status) status = rename_durably(part, path);
  std::error_code ignored;
  if (!status) std::filesystem::remove(part, ignored);
  return status;
}

}  // namespace cairn
