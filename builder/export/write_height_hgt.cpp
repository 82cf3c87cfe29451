#include <system_error>
#include <vector>

#include "builder/export/height_image.h"
#include "builder/export/whole_metres.h"
#include "format/file.h"

namespace cairn {
namespace {

Status write_part(File& file, const HeightGrid& grid, const HeightRows& rows) {
  if (auto status = file.truncate(0); !status) return status;
  std::vector<double> metres(static_cast<std::size_t>(grid.posts.columns));
  std::vector<std::byte> row(2 * metres.size());
  for (int r = 0; r < grid.posts.rows; ++r) {
    if (auto filled = rows(r, metres); !filled) return filled;
    for (std::size_t c = 0; c < metres.size(); ++c) {
      const auto value = static_cast<std::uint16_t>(whole_metres(metres[c]));
      row[2 * c] = static_cast<std::byte>(value >> 8);
      row[2 * c + 1] = static_cast<std::byte>(value & 0xFF);
    }
    if (auto written = file.write(static_cast<std::uint64_t>(r) * row.size(), row); !written) return written;
  }
  return file.sync();
}

}  // namespace

Status write_height_hgt(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows) {
  const std::filesystem::path part = path.string() + ".part";
  auto file = File::open_to_write(part);
  if (!file) return file.error();
  Status status = write_part(*file, grid, rows);
  if (status) status = rename_durably(part, path);
  std::error_code ignored;
  if (!status) std::filesystem::remove(part, ignored);
  return status;
}

}  // namespace cairn
