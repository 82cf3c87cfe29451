#include "builder/export/jpeg_writer.h"

#include <cassert>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>

#include "format/file.h"

namespace cairn {

/// libjpeg's errors jump, so each call into it stands alone in a function that holds no objects.
struct JpegWriter::State {
  ~State() {
    jpeg_destroy_compress(&jpeg);
    if (file != nullptr) std::fclose(file);
    std::error_code ignored;
    if (made && !finished) std::filesystem::remove(part, ignored);
  }

  bool start(int columns) {
    constexpr int kQuality = 90;
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = keep_complaint;
    errors.output_message = [](j_common_ptr) {};
    if (setjmp(jump) != 0) return false;
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = static_cast<JDIMENSION>(columns);
    jpeg.image_height = static_cast<JDIMENSION>(rows);
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, kQuality, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    return true;
  }
  bool write(const std::uint8_t* row) {
    if (setjmp(jump) != 0) return false;
    JSAMPROW pointer = const_cast<JSAMPROW>(row);
    return jpeg_write_scanlines(&jpeg, &pointer, 1) == 1;
  }
  bool end() {
    if (setjmp(jump) != 0) return false;
    jpeg_finish_compress(&jpeg);
    return true;
  }
  [[noreturn]] static void keep_complaint(j_common_ptr common) {
    auto* state = static_cast<State*>(common->client_data);
    common->err->format_message(common, state->complaint);
    if (errno != 0) std::strncpy(state->complaint, std::strerror(errno), sizeof state->complaint - 1);
    std::longjmp(state->jump, 1);
  }
  Error error() const { return failed(part.string() + ": " + complaint); }

  std::filesystem::path target;
  std::filesystem::path part;
  std::FILE* file = nullptr;
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf jump{};
  std::size_t row_bytes = 0;
  int next_row = 0;
  int rows = 0;
  bool made = false;
  bool finished = false;
  char complaint[JMSG_LENGTH_MAX] = "libjpeg cannot start";
};

JpegWriter::JpegWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
JpegWriter::JpegWriter(JpegWriter&&) noexcept = default;
JpegWriter& JpegWriter::operator=(JpegWriter&&) noexcept = default;
JpegWriter::~JpegWriter() = default;

Result<JpegWriter> JpegWriter::create(const std::filesystem::path& target, int columns, int rows) {
  if (columns > JPEG_MAX_DIMENSION || rows > JPEG_MAX_DIMENSION)
    return usage_error(target.string() + ": expected at most " + std::to_string(JPEG_MAX_DIMENSION) +
                       " pixels along a side of a JPEG, found " + std::to_string(std::max(columns, rows)));
  auto state = std::make_unique<State>();
  state->target = target;
  state->part = target.string() + ".part";
  state->row_bytes = static_cast<std::size_t>(columns) * 3;
  state->rows = rows;
  state->file = std::fopen(state->part.c_str(), "wb");
  if (state->file == nullptr) return failed(state->part.string() + ": " + std::strerror(errno));
  state->made = true;
  errno = 0;
  if (!state->start(columns)) return state->error();
  return JpegWriter(std::move(state));
}

Status JpegWriter::write_row(std::span<const std::uint8_t> rgb) {
  assert(rgb.size() == state_->row_bytes && state_->next_row < state_->rows);
  ++state_->next_row;
  errno = 0;
  return state_->write(rgb.data()) ? Status() : state_->error();
}

Status JpegWriter::finish() {
  assert(state_->next_row == state_->rows);
  errno = 0;
  if (!state_->end()) return state_->error();
  std::FILE* file = std::exchange(state_->file, nullptr);
  if (std::fclose(file) != 0) return failed(state_->part.string() + ": " + std::strerror(errno));
  const Status renamed = rename_durably(state_->part, state_->target);
  state_->finished = renamed.ok();
  return renamed;
}

}  // namespace cairn
