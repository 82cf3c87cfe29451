#include "builder/export/png_writer.h"

#include <cassert>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include <png.h>

#include "format/file.h"

namespace cairn {

/// libpng's errors jump, so each call into it stands alone in a function that holds no objects.
struct PngWriter::State {
  ~State() {
    png_destroy_write_struct(&png, &info);
    if (file != nullptr) std::fclose(file);
    if (finished) return;
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
  }

  bool start(int columns, Pixel pixel) {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, keep_complaint, nullptr);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) return false;
    const bool colour = pixel == Pixel::rgba8;
    png_init_io(png, file);
    png_set_IHDR(png, info, static_cast<png_uint_32>(columns), static_cast<png_uint_32>(rows),
                 colour ? 8 : 16, colour ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    if (colour) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (!colour) png_set_swap(png);
    return true;
  }
  bool write(const std::byte* row) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_write_row(png, reinterpret_cast<png_const_bytep>(row));
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_write_end(png, info);
    return true;
  }
  [[noreturn]] static void keep_complaint(png_structp png, png_const_charp text) {
    auto* state = static_cast<State*>(png_get_error_ptr(png));
    std::strncpy(state->complaint, errno != 0 ? std::strerror(errno) : text, sizeof state->complaint - 1);
    png_longjmp(png, 1);
  }
  Error error() const { return failed(part.string() + ": " + complaint); }

  std::filesystem::path target;
  std::filesystem::path part;
  std::FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::size_t row_bytes = 0;
  int next_row = 0;
  int rows = 0;
  bool finished = false;
  char complaint[128] = "libpng cannot start";
};

PngWriter::PngWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PngWriter::PngWriter(PngWriter&&) noexcept = default;
PngWriter& PngWriter::operator=(PngWriter&&) noexcept = default;
PngWriter::~PngWriter() = default;

Result<PngWriter> PngWriter::create(const std::filesystem::path& target, int columns, int rows, Pixel pixel) {
  auto state = std::make_unique<State>();
  state->target = target;
  state->part = target.string() + ".part";
  state->row_bytes = static_cast<std::size_t>(columns) * (pixel == Pixel::rgba8 ? 4 : 2);
  state->rows = rows;
  state->file = std::fopen(state->part.c_str(), "wb");
  if (state->file == nullptr) return failed(state->part.string() + ": " + std::strerror(errno));
  errno = 0;
  if (!state->start(columns, pixel)) return state->error();
  return PngWriter(std::move(state));
}

Status PngWriter::write_row(std::span<const std::byte> row) {
  assert(row.size() == state_->row_bytes && state_->next_row < state_->rows);
  ++state_->next_row;
  errno = 0;
  return state_->write(row.data()) ? Status() : state_->error();
}

Status PngWriter::finish() {
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
