#pragma once

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>

namespace cairn {

/// The bytes of a JPEG in memory that libjpeg has allocated.
struct JpegBytes {
  unsigned char* data = nullptr;
  unsigned long size = 0;

  JpegBytes() = default;
  JpegBytes(const JpegBytes&) = delete;
  JpegBytes& operator=(const JpegBytes&) = delete;
  ~JpegBytes() { std::free(data); }
};

/// Encodes a JPEG in RGB row by row. Where a function returns false, `complaint` says why, and nothing more
/// may be called.
///
/// libjpeg's errors jump, so each call into it stands alone in a function that holds no objects.
class JpegEncoder {
 public:
  JpegEncoder() = default;
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  ~JpegEncoder() { jpeg_destroy_compress(&jpeg_); }

  /// REQUIRES: the destination outlives the encoder's last call.
  bool start(int columns, int rows, std::FILE* file) { return start(columns, rows, file, nullptr); }
  bool start(int columns, int rows, JpegBytes& bytes) { return start(columns, rows, nullptr, &bytes); }

  /// The next row from the top, 3 bytes a pixel.
  bool write(const std::uint8_t* row);

  bool end();

  const char* complaint() const { return complaint_; }

 private:
  bool start(int columns, int rows, std::FILE* file, JpegBytes* bytes);
  [[noreturn]] static void keep_complaint(j_common_ptr common);

  jpeg_compress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  std::jmp_buf jump_{};
  char complaint_[JMSG_LENGTH_MAX] = "libjpeg cannot start";
};

}  // namespace cairn
