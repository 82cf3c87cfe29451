#include <vector>

#include "builder/export/height_image.h"
#include "builder/export/whole_metres.h"

namespace cairn {
namespace {

template <class T, class Convert>
Status write_rows(TiffWriter& tiff, const HeightGrid& grid, const HeightRows& rows, Convert convert) {
  std::vector<double> metres(static_cast<std::size_t>(grid.posts.columns));
  std::vector<T> row(metres.size());
  for (int r = 0; r < grid.posts.rows; ++r) {
    if (auto filled = rows(r, metres); !filled) return filled;
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = convert(metres[c]);
    if (auto written = tiff.write_row(std::as_writable_bytes(std::span(row))); !written) return written;
  }
  return tiff.finish();
}

}  // namespace

Status write_height_tiff(const std::filesystem::path& path, const HeightGrid& grid, const HeightRows& rows) {
  const auto pixel = grid.whole_metres ? TiffWriter::Pixel::int16 : TiffWriter::Pixel::float32;
  auto tiff = TiffWriter::create(path, grid.posts, pixel, grid.datum);
  if (!tiff) return tiff.error();
  if (grid.whole_metres) return write_rows<std::int16_t>(*tiff, grid, rows, whole_metres);
  return write_rows<float>(*tiff, grid, rows, [](double metres) {
    return metres != metres ? static_cast<float>(kVoidMetres) : static_cast<float>(metres);
  });
}

}  // namespace cairn
