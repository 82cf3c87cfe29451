#include <vector>

#include "builder/export/height_image.h"
#include "builder/export/png_writer.h"
#include "builder/export/whole_metres.h"

namespace cairn {

Status write_height_png(const std::filesystem::path& path, const HeightImage& image) {
  auto picture = PngWriter::create(path, image.size, image.size, PngWriter::Pixel::grey16);
  if (!picture) return picture.error();
  const auto size = static_cast<std::size_t>(image.size);
  std::vector<std::uint16_t> row(size);
  for (std::size_t r = 0; r < size; ++r) {
    for (std::size_t c = 0; c < size; ++c) {
      row[c] = static_cast<std::uint16_t>(whole_metres(image.metres[r * size + c]) + 32768);
    }
    if (const Status status = picture->write_row(std::as_bytes(std::span(row))); !status) return status;
  }
  return picture->finish();
}

}  // namespace cairn
