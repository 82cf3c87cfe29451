#include <vector>

#include "builder/export/height_image.h"
#include "builder/export/png_writer.h"
#include "builder/export/whole_metres.h"

namespace cairn {

Status write_height_png(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows) {
  auto picture = PngWriter::create(path, grid.posts.columns, grid.posts.rows, PngWriter::Pixel::grey16);
  if (!picture) return picture.error();
  std::vector<double> metres(static_cast<std::size_t>(grid.posts.columns));
  std::vector<std::uint16_t> row(metres.size());
  for (int r = 0; r < grid.posts.rows; ++r) {
    if (auto filled = rows(r, metres); !filled) return filled;
    for (std::size_t c = 0; c < row.size(); ++c)
      row[c] = static_cast<std::uint16_t>(whole_metres(metres[c]) + 32768);
    if (auto written = picture->write_row(std::as_bytes(std::span(row))); !written) return written;
  }
  return picture->finish();
}

}  // namespace cairn
