#include "builder/export/jpeg_encoder.h"

#include <cerrno>
#include <cstring>

namespace cairn {

bool JpegEncoder::start(int columns, int rows, std::FILE* file, JpegBytes* bytes) {
  constexpr int kQuality = 90;
  errno = 0;
  jpeg_.err = jpeg_std_error(&errors_);
  jpeg_.client_data = this;
  errors_.error_exit = keep_complaint;
  errors_.output_message = [](j_common_ptr) {};
  if (setjmp(jump_) != 0) return false;
  jpeg_create_compress(&jpeg_);
  if (file != nullptr) jpeg_stdio_dest(&jpeg_, file);
  if (bytes != nullptr) jpeg_mem_dest(&jpeg_, &bytes->data, &bytes->size);
  jpeg_.image_width = static_cast<JDIMENSION>(columns);
  jpeg_.image_height = static_cast<JDIMENSION>(rows);
  jpeg_.input_components = 3;
  jpeg_.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg_);
  jpeg_set_quality(&jpeg_, kQuality, TRUE);
  jpeg_start_compress(&jpeg_, TRUE);
  return true;
}

bool JpegEncoder::write(const std::uint8_t* row) {
  errno = 0;
  if (setjmp(jump_) != 0) return false;
  JSAMPROW pointer = const_cast<JSAMPROW>(row);
  return jpeg_write_scanlines(&jpeg_, &pointer, 1) == 1;
}

bool JpegEncoder::end() {
  errno = 0;
  if (setjmp(jump_) != 0) return false;
  jpeg_finish_compress(&jpeg_);
  return true;
}

void JpegEncoder::keep_complaint(j_common_ptr common) {
  auto* encoder = static_cast<JpegEncoder*>(common->client_data);
  common->err->format_message(common, encoder->complaint_);
  if (errno != 0) std::strncpy(encoder->complaint_, std::strerror(errno), sizeof encoder->complaint_ - 1);
  std::longjmp(encoder->jump_, 1);
}

}  // namespace cairn
