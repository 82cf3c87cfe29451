#include "builder/picture_file.h"

#include <cassert>
#include <system_error>

#include <OpenImageIO/imageio.h>

#include "format/file.h"

namespace cairn {

struct PictureFile::State {
  ~State() {
    if (finished) return;
    if (output) output->close();
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
  }
  Error error() const { return failed(part.string() + ": " + output->geterror()); }

  std::filesystem::path target;
  std::filesystem::path part;
  std::unique_ptr<OIIO::ImageOutput> output;
  OIIO::TypeDesc type;
  std::size_t row_bytes = 0;
  int next_row = 0;
  int rows = 0;
  bool finished = false;
};

PictureFile::PictureFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
PictureFile::PictureFile(PictureFile&&) noexcept = default;
PictureFile& PictureFile::operator=(PictureFile&&) noexcept = default;
PictureFile::~PictureFile() = default;

Result<PictureFile> PictureFile::create(const std::filesystem::path& target, int columns, int rows,
                                        Pixel pixel) {
  auto state = std::make_unique<State>();
  const int channels = pixel == Pixel::rgba8 ? 4 : 1;
  state->target = target;
  state->part = target.string() + ".part";
  state->type = pixel == Pixel::rgba8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16;
  state->row_bytes =
      static_cast<std::size_t>(columns) * static_cast<std::size_t>(channels) * state->type.size();
  state->rows = rows;
  state->output = OIIO::ImageOutput::create("png");
  if (!state->output) return failed(target.string() + ": OpenImageIO cannot write PNG: " + OIIO::geterror());
  OIIO::ImageSpec spec(columns, rows, channels, state->type);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  if (pixel == Pixel::rgba8) spec.attribute("oiio:ColorSpace", "sRGB");
  if (!state->output->open(state->part.string(), spec)) return state->error();
  return PictureFile(std::move(state));
}

Status PictureFile::write_row(std::span<const std::byte> row) {
  assert(row.size() == state_->row_bytes && state_->next_row < state_->rows);
  if (!state_->output->write_scanline(state_->next_row++, 0, state_->type, row.data()))
    return state_->error();
  return {};
}

Status PictureFile::finish() {
  assert(state_->next_row == state_->rows);
  if (!state_->output->close()) return state_->error();
  const Status renamed = rename_durably(state_->part, state_->target);
  state_->finished = renamed.ok();
  return renamed;
}

}  // namespace cairn
