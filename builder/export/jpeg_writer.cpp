#include "builder/export/jpeg_writer.h"

#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "builder/export/jpeg_encoder.h"
#include "format/file.h"

namespace cairn {

struct JpegWriter::State {
  ~State() {
    if (file != nullptr) std::fclose(file);
    std::error_code ignored;
    if (made && !finished) std::filesystem::remove(part, ignored);
  }
  Error error() const { return failed(part.string() + ": " + encoder.complaint()); }

  std::filesystem::path target;
  std::filesystem::path part;
  std::FILE* file = nullptr;
  JpegEncoder encoder;
  std::size_t row_bytes = 0;
  int next_row = 0;
  int rows = 0;
  bool made = false;
  bool finished = false;
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
  if (!state->encoder.start(columns, rows, state->file)) return state->error();
  return JpegWriter(std::move(state));
}

Status JpegWriter::write_row(std::span<const std::uint8_t> rgb) {
  assert(rgb.size() == state_->row_bytes && state_->next_row < state_->rows);
  ++state_->next_row;
  return state_->encoder.write(rgb.data()) ? Status() : state_->error();
}

Status JpegWriter::finish() {
  assert(state_->next_row == state_->rows);
  if (!state_->encoder.end()) return state_->error();
  std::FILE* file = std::exchange(state_->file, nullptr);
  if (std::fclose(file) != 0) return failed(state_->part.string() + ": " + std::strerror(errno));
  const Status renamed = rename_durably(state_->part, state_->target);
  state_->finished = renamed.ok();
  return renamed;
}

}  // namespace cairn
