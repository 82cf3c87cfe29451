// PNG with a world file: palettes and fewer than 8 bits come as 8-bit colours, a transparent colour as alpha.
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <png.h>

#include "builder/raster/height_encoding.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/scanline_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".png"};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// libpng's reader. Its errors jump, so each call into it stands alone in a function that holds no objects.
class PngReader {
 public:
  explicit PngReader(const fs::path& path) : file_(std::fopen(path.c_str(), "rb")) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, keep_complaint, ignore_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  bool read_header() {
    if (file_ == nullptr || info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_init_io(png_, file_.get());
    png_read_info(png_, info_);
    png_set_expand(png_);
    if (png_get_bit_depth(png_, info_) == 16) png_set_swap(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  bool read_row(std::byte* row) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_row(png_, reinterpret_cast<png_bytep>(row), nullptr);
    return true;
  }
  bool read_end() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_end(png_, nullptr);
    return true;
  }

  ScanlineHeader header() const {
    return {png_get_image_width(png_, info_), png_get_image_height(png_, info_),
            png_get_channels(png_, info_),
            png_get_bit_depth(png_, info_) == 16 ? SampleType::uint16 : SampleType::uint8};
  }
  int passes() const { return passes_; }
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  const char* complaint() const { return complaint_; }

 private:
  [[noreturn]] static void keep_complaint(png_structp png, png_const_charp text) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->complaint_, text, sizeof reader->complaint_ - 1);
    png_longjmp(png, 1);
  }
  static void ignore_warning(png_structp, png_const_charp) {}

  std::unique_ptr<std::FILE, CloseFile> file_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
  char complaint_[128] = "damaged data";
};

Error damaged(const fs::path& path, const std::string& place, const PngReader& reader) {
  return bad_data(path.string() + ": " + place + ": expected a PNG, found: " + reader.complaint());
}

/// An interlaced image comes in passes over all its rows, so it is held whole.
Status read_interlaced(PngReader& reader, const fs::path& path, const ScanlineHeader& header,
                       const RowSink& sink) {
  std::vector<std::byte> image(reader.row_bytes() * static_cast<std::size_t>(header.rows));
  for (int pass = 0; pass < reader.passes(); ++pass)
    for (std::size_t at = 0; at < image.size(); at += reader.row_bytes())
      if (!reader.read_row(image.data() + at)) return damaged(path, "pass " + std::to_string(pass), reader);
  return sink(image);
}

Status decode(const fs::path& path, const ScanlineHeader& header, const RowSink& sink) {
  PngReader reader(path);
  if (!reader.read_header()) return damaged(path, "header", reader);
  if (reader.passes() > 1) return read_interlaced(reader, path, header, sink);
  std::vector<std::byte> row(reader.row_bytes());
  for (std::int64_t r = 0; r < header.rows; ++r) {
    if (!reader.read_row(row.data())) return damaged(path, "row " + std::to_string(r), reader);
    if (auto kept = sink(row); !kept) return kept;
  }
  return reader.read_end() ? Status() : damaged(path, "end", reader);
}

bool claims(const fs::path&, std::span<const std::byte> first) {
  return first.size() >= 8 && std::memcmp(first.data(), "\x89PNG\r\n\x1a\n", 8) == 0;
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  PngReader reader(path);
  if (!reader.read_header()) return damaged(path, "header", reader);
  return open_scanline_raster("png", path, reader.header(), decode, options);
}

}  // namespace

extern const RasterFormat png_format;
const RasterFormat png_format = {"png", 40, claims, open};

extern const RasterNames png_names;
const RasterNames png_names = {kExtensions};

}  // namespace cairn
