#include "builder/raster/tiff/tiff_image.h"

#include <algorithm>
#include <cassert>
#include <string>

#include <fmt/format.h>
#include <tiffio.h>

#include "builder/raster/height_encoding.h"
#include "builder/raster/tiff/tiff_layout.h"

namespace cairn {

/// The overlap of a window and a chunk. Rows and columns are relative to the chunk's corner.
struct TiffImage::Part {
  std::int64_t chunk = 0;
  int plane = 0;
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::int64_t window_column = 0;  // where the part's corner lies in the window
  std::int64_t window_row = 0;
  std::int64_t image_row = 0;   // and in the image
  std::int64_t chunk_rows = 0;  // rows that the chunk stores: the last strip has fewer
};

namespace {

constexpr std::int64_t kReadAtOnce = 256 * 1024;
constexpr std::int64_t kShortRow = 4096;  // bytes that cost less to read than to ask for apart

std::size_t pixel_bytes(const TiffLayout& layout) {
  return size_of(layout.type) * static_cast<std::size_t>(layout.samples_together());
}

std::size_t decoded_row_bytes(const TiffLayout& layout) {
  return static_cast<std::size_t>(layout.chunk_columns) * pixel_bytes(layout);
}

}  // namespace

TiffImage::TiffImage(std::filesystem::path path, InputFile file, std::uint16_t directory,
                     std::size_t cache_bytes)
    : path_(path),
      file_(std::move(file)),
      handles_(std::move(path), directory),
      cache_(cache_bytes),
      scratch_(cache_bytes) {}

Result<std::unique_ptr<TiffImage>> TiffImage::open(const std::filesystem::path& path,
                                                   std::unique_ptr<TiffHandle> handle,
                                                   std::uint16_t directory, std::size_t cache_bytes) {
  auto file = InputFile::open(path);
  if (!file) return file.error();
  auto layout = read_tiff_layout(path, *handle);
  if (!layout) return layout.error();
  std::unique_ptr<TiffImage> image(new TiffImage(path, std::move(*file), directory, cache_bytes));
  image->layout_ = std::move(*layout);
  std::uint16_t fill_order = FILLORDER_MSB2LSB;
  TIFFGetFieldDefaulted(handle->get(), TIFFTAG_FILLORDER, &fill_order);
  const TiffLayout& l = image->layout_;
  image->stored_ = l.compression == COMPRESSION_NONE && l.bits >= 8 && fill_order == FILLORDER_MSB2LSB &&
                   l.photometric != PHOTOMETRIC_YCBCR;
  image->swapped_ = TIFFIsByteSwapped(handle->get()) != 0;
  if (auto table = image->read_chunk_table(*handle); !table) return table.error();
  const auto chunk_bytes = decoded_row_bytes(l) * static_cast<std::size_t>(l.chunk_rows);
  image->kept_ = image->stored_ && l.tiled && l.samples_together() >= 3 && chunk_bytes <= cache_bytes / 8;
  image->through_scratch_ = !image->stored_ && !l.tiled && chunk_bytes > cache_bytes / 2;
  if (!image->stored_) image->handles_.give_back(std::move(handle));
  return image;
}

Status TiffImage::read_chunk_table(const TiffHandle& handle) {
  const std::int64_t chunks =
      layout_.chunks_across() * layout_.chunks_down() * (layout_.planar ? layout_.bands : 1);
  const std::int64_t rows_bytes = packed_row_bytes(layout_);
  for (std::int64_t i = 0; i < chunks; ++i) {
    const std::uint64_t offset = TIFFGetStrileOffset(handle.get(), static_cast<std::uint32_t>(i));
    std::uint64_t count = TIFFGetStrileByteCount(handle.get(), static_cast<std::uint32_t>(i));
    const std::int64_t down = i / layout_.chunks_across() % layout_.chunks_down();
    const std::int64_t rows = layout_.tiled
                                  ? layout_.chunk_rows
                                  : std::min(layout_.chunk_rows, layout_.rows - down * layout_.chunk_rows);
    const auto whole = static_cast<std::uint64_t>(rows * rows_bytes);
    const bool sparse = offset == 0 && count == 0;
    if (offset > file_.size() || count > file_.size() - offset || (stored_ && !sparse && count < whole))
      return bad_data(fmt::format("{}: {}: expected {} bytes at byte {}, found a file of {}", path_.string(),
                                  place_of_chunk(i), stored_ ? whole : count, offset, file_.size()));
    offsets_.push_back(offset);
    byte_counts_.push_back(count);
  }
  return {};
}

std::string TiffImage::place_of_chunk(std::int64_t chunk) const {
  const std::int64_t in_plane = chunk % (layout_.chunks_across() * layout_.chunks_down());
  const std::int64_t across = in_plane % layout_.chunks_across(), down = in_plane / layout_.chunks_across();
  return fmt::format("{} at column {}, row {}", layout_.tiled ? "tile" : "strip",
                     across * layout_.chunk_columns, down * layout_.chunk_rows);
}

Status TiffImage::visit(const PostWindow& w, int plane, const std::function<void(const Run&)>& run) const {
  const TiffLayout& l = layout_;
  assert(w.column >= 0 && w.row >= 0 && w.column + w.columns <= l.columns && w.row + w.rows <= l.rows);
  for (std::int64_t down = w.row / l.chunk_rows; down * l.chunk_rows < w.row + w.rows; ++down) {
    for (std::int64_t across = w.column / l.chunk_columns; across * l.chunk_columns < w.column + w.columns;
         ++across) {
      const std::int64_t left = across * l.chunk_columns, top = down * l.chunk_rows;
      Part part;
      part.plane = plane;
      part.chunk = (plane * l.chunks_down() + down) * l.chunks_across() + across;
      part.column = std::max(w.column - left, std::int64_t{0});
      part.row = std::max(w.row - top, std::int64_t{0});
      part.columns = std::min(w.column + w.columns - left, l.chunk_columns) - part.column;
      part.rows = std::min(w.row + w.rows - top, l.chunk_rows) - part.row;
      part.window_column = left + part.column - w.column;
      part.window_row = top + part.row - w.row;
      part.image_row = top + part.row;
      part.chunk_rows = l.tiled ? l.chunk_rows : std::min(l.chunk_rows, l.rows - top);
      const Status visited = stored_ && !kept_  ? visit_stored(part, run)
                             : through_scratch_ ? visit_scratch(part, run)
                                                : visit_decoded(part, run);
      if (!visited) return visited;
    }
  }
  return {};
}

/// Reads rows of the chunk as they lie in the file: each row's pixels alone where they are few of the row,
/// else many rows at once.
Status TiffImage::visit_stored(const Part& part, const std::function<void(const Run&)>& run) const {
  const auto chunk = static_cast<std::size_t>(part.chunk);
  if (byte_counts_[chunk] == 0) return visit_decoded(part, run);
  const auto pixel = static_cast<std::int64_t>(pixel_bytes(layout_));
  const std::int64_t stride = layout_.chunk_columns * pixel, wanted = part.columns * pixel;
  const std::int64_t rows_at_once =
      stride <= kShortRow || 2 * wanted >= stride ? std::max<std::int64_t>(1, kReadAtOnce / stride) : 1;
  std::vector<std::byte> bytes;
  for (std::int64_t done = 0; done < part.rows; done += rows_at_once) {
    const std::int64_t rows = std::min(rows_at_once, part.rows - done);
    bytes.resize(static_cast<std::size_t>((rows - 1) * stride + wanted));
    const std::int64_t at = (part.row + done) * stride + part.column * pixel;
    if (auto read = file_.read_at(offsets_[chunk] + static_cast<std::uint64_t>(at), bytes); !read)
      return read;
    if (swapped_) swap_bytes(bytes.data(), bytes.size() / size_of(layout_.type), size_of(layout_.type));
    for (std::int64_t r = 0; r < rows; ++r)
      run({part.window_column, part.window_row + done + r, part.columns, bytes.data() + r * stride});
  }
  return {};
}

Status TiffImage::visit_decoded(const Part& part, const std::function<void(const Run&)>& run) const {
  if (byte_counts_[static_cast<std::size_t>(part.chunk)] == 0) {
    for (std::int64_t r = 0; r < part.rows; ++r)
      run({part.window_column, part.window_row + r, part.columns, nullptr});
    return {};
  }
  const auto decoded = cache_.get(static_cast<std::uint64_t>(part.chunk),
                                  [&] { return decode_chunk(part.chunk, part.chunk_rows); });
  if (!decoded) return decoded.error();
  const std::size_t stride = decoded_row_bytes(layout_);
  const std::byte* first = (*decoded)->data() + static_cast<std::size_t>(part.row) * stride +
                           static_cast<std::size_t>(part.column) * pixel_bytes(layout_);
  for (std::int64_t r = 0; r < part.rows; ++r)
    run({part.window_column, part.window_row + r, part.columns,
         first + static_cast<std::size_t>(r) * stride});
  return {};
}

Result<ChunkCache::Chunk> TiffImage::read_chunk(std::int64_t chunk, std::int64_t rows) const {
  ChunkCache::Chunk bytes = cache_.room_for(static_cast<std::size_t>(rows) * decoded_row_bytes(layout_));
  if (auto read = file_.read_at(offsets_[static_cast<std::size_t>(chunk)], bytes); !read) return read.error();
  if (swapped_) swap_bytes(bytes.data(), bytes.size() / size_of(layout_.type), size_of(layout_.type));
  return bytes;
}

Result<ChunkCache::Chunk> TiffImage::decode_chunk(std::int64_t chunk, std::int64_t rows) const {
  if (stored_) return read_chunk(chunk, rows);
  auto handle = handles_.take();
  if (!handle) return handle.error();
  ChunkCache::Chunk bytes = cache_.room_for(static_cast<std::size_t>(rows * packed_row_bytes(layout_)));
  const auto number = static_cast<std::uint32_t>(chunk);
  const auto size = static_cast<tmsize_t>(bytes.size());
  (*handle)->note({});
  const tmsize_t got = layout_.tiled ? TIFFReadEncodedTile((*handle)->get(), number, bytes.data(), size)
                                     : TIFFReadEncodedStrip((*handle)->get(), number, bytes.data(), size);
  const std::string reason = (*handle)->reason();
  handles_.give_back(std::move(*handle));
  if (got != size)
    return bad_data(fmt::format("{}: {}: expected {} bytes, found {}: {}", path_.string(),
                                place_of_chunk(chunk), size, std::max<tmsize_t>(got, 0), reason));
  if (layout_.bits >= 8) return bytes;
  const std::vector<std::byte> unpacked = unpack_bits(layout_, bytes);
  return ChunkCache::Chunk(unpacked.begin(), unpacked.end());
}

Status TiffImage::visit_scratch(const Part& part, const std::function<void(const Run&)>& run) const {
  std::call_once(scratch_once_, [this] { scratch_status_ = unpack_to_scratch(); });
  if (!scratch_status_) return scratch_status_;
  std::vector<std::byte> row(static_cast<std::size_t>(part.columns) * pixel_bytes(layout_));
  for (std::int64_t r = 0; r < part.rows; ++r) {
    const std::int64_t image_row = part.plane * layout_.rows + part.image_row + r;
    const std::size_t at = static_cast<std::size_t>(image_row) * decoded_row_bytes(layout_) +
                           static_cast<std::size_t>(part.column) * pixel_bytes(layout_);
    if (auto read = scratch_.read_at(at, row); !read) return read;
    run({part.window_column, part.window_row + r, part.columns, row.data()});
  }
  return {};
}

Status TiffImage::unpack_to_scratch() const {
  auto handle = handles_.take();
  if (!handle) return handle.error();
  std::vector<std::byte> row(static_cast<std::size_t>(TIFFScanlineSize64((*handle)->get())));
  if (row.size() != static_cast<std::size_t>(packed_row_bytes(layout_)))
    return bad_data(fmt::format("{}: rows: expected {} bytes, found {}", path_.string(),
                                packed_row_bytes(layout_), row.size()));
  for (int plane = 0; plane < (layout_.planar ? layout_.bands : 1); ++plane) {
    for (std::int64_t r = 0; r < layout_.rows; ++r) {
      if (TIFFReadScanline((*handle)->get(), row.data(), static_cast<std::uint32_t>(r),
                           static_cast<std::uint16_t>(plane)) != 1)
        return bad_data(
            fmt::format("{}: row {}: expected pixels, found: {}", path_.string(), r, (*handle)->reason()));
      const Status kept =
          layout_.bits < 8 ? scratch_.append(unpack_bits(layout_, row)) : scratch_.append(row);
      if (!kept) return kept;
    }
  }
  return {};
}

}  // namespace cairn
