// JPEG imagery, placed by a world file or by bounds.
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>
// and this one jpeglib.h.
#include <jerror.h>

#include "builder/raster/raster_names.h"
#include "builder/raster/scanline_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".jpg", ".jpeg"};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// libjpeg's reader. Its errors jump, so each call into it stands alone in a function that holds no objects.
class JpegReader {
 public:
  explicit JpegReader(const fs::path& path) : file_(std::fopen(path.c_str(), "rb")) {
    jpeg_.err = jpeg_std_error(&errors_);
    jpeg_.client_data = this;
    errors_.error_exit = jump;
    errors_.emit_message = note;
    errors_.output_message = say_nothing;
    created_ = file_ != nullptr && create();
  }
  ~JpegReader() {
    if (created_) jpeg_destroy_decompress(&jpeg_);
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  bool read_header() {
    if (!created_ || setjmp(back_) != 0) return false;
    jpeg_stdio_src(&jpeg_, file_.get());
    jpeg_read_header(&jpeg_, TRUE);
    return true;
  }
  bool start() {
    if (setjmp(back_) != 0) return false;
    jpeg_.out_color_space = jpeg_.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&jpeg_);
    return true;
  }
  /// Decoders fill what is missing or damaged with grey and go on; here that is an error.
  bool read_row(std::byte* row) {
    if (setjmp(back_) != 0) return false;
    auto* rows = reinterpret_cast<JSAMPROW>(row);
    return jpeg_read_scanlines(&jpeg_, &rows, 1) == 1 && !damaged_;
  }

  bool is_cmyk() const { return jpeg_.jpeg_color_space == JCS_CMYK || jpeg_.jpeg_color_space == JCS_YCCK; }
  ScanlineHeader header() const {
    return {jpeg_.image_width, jpeg_.image_height, jpeg_.num_components == 1 ? 1 : 3, SampleType::uint8};
  }
  const char* complaint() const { return complaint_; }

 private:
  bool create() {
    if (setjmp(back_) != 0) return false;
    jpeg_create_decompress(&jpeg_);
    return true;
  }
  void keep_complaint() { (*errors_.format_message)(reinterpret_cast<j_common_ptr>(&jpeg_), complaint_); }
  [[noreturn]] static void jump(j_common_ptr jpeg) {
    auto* reader = static_cast<JpegReader*>(jpeg->client_data);
    reader->keep_complaint();
    std::longjmp(reader->back_, 1);
  }
  static void note(j_common_ptr jpeg, int level) {
    auto* reader = static_cast<JpegReader*>(jpeg->client_data);
    if (level >= 0 || jpeg->err->msg_code == JWRN_EXTRANEOUS_DATA) return;  // a remark, not a warning
    reader->damaged_ = true;
    reader->keep_complaint();
  }
  static void say_nothing(j_common_ptr) {}

  std::unique_ptr<std::FILE, CloseFile> file_;
  jpeg_decompress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  std::jmp_buf back_{};
  bool created_ = false;
  bool damaged_ = false;
  char complaint_[JMSG_LENGTH_MAX] = "damaged data";
};

Error damaged(const fs::path& path, const std::string& place, const JpegReader& reader) {
  return bad_data(path.string() + ": " + place + ": expected a JPEG, found: " + reader.complaint());
}

Status decode(const fs::path& path, const ScanlineHeader& header, const RowSink& sink) {
  JpegReader reader(path);
  if (!reader.read_header() || !reader.start()) return damaged(path, "header", reader);
  std::vector<std::byte> row(static_cast<std::size_t>(header.columns * header.bands));
  for (std::int64_t r = 0; r < header.rows; ++r) {
    if (!reader.read_row(row.data())) return damaged(path, "row " + std::to_string(r), reader);
    if (auto kept = sink(row); !kept) return kept;
  }
  return {};
}

bool claims(const fs::path&, std::span<const std::byte> first) {
  return first.size() >= 3 && std::memcmp(first.data(), "\xFF\xD8\xFF", 3) == 0;
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  JpegReader reader(path);
  if (!reader.read_header()) return damaged(path, "header", reader);
  if (reader.is_cmyk()) return bad_data(path.string() + ": image: expected RGB or grey, found CMYK");
  return open_scanline_raster("jpeg", path, reader.header(), decode, options);
}

}  // namespace

extern const RasterFormat jpeg_format;
const RasterFormat jpeg_format = {"jpeg", 41, claims, open};

extern const RasterNames jpeg_names;
const RasterNames jpeg_names = {kExtensions};

}  // namespace cairn
