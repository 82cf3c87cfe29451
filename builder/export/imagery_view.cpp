#include "builder/export/imagery_view.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>

// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>

#include "builder/export/texture_file.h"
#include "format/block_texture.h"

namespace cairn {
namespace {

constexpr std::size_t kMostTiles = 16;

/// Decoded finest mips of the tiles that a picture touches.
class Texels {
 public:
  explicit Texels(const PackReader& pack) : pack_(pack), size_(pack.header().tile_size - 1) {}

  /// Four bytes; null where no tile has the place.
  Result<const std::uint8_t*> at(LonLat place, int level) {
    const auto entry = pack_.find_nearest(Layer::imagery, tile_at(place, level));
    if (!entry) return static_cast<const std::uint8_t*>(nullptr);
    auto found = tiles_.find(entry->id);
    if (found == tiles_.end()) {
      const auto tile = read_texture_tile(pack_, *entry);
      if (!tile) return tile.error();
      std::vector<std::uint8_t> rgba(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_) * 4);
      const auto finest = std::span(tile->texels).first(texture_image_bytes(tile->format, tile->size));
      if (auto status = decode_texture(tile->format, finest, size_, size_, rgba); !status)
        return status.error();
      if (tiles_.size() >= kMostTiles) tiles_.clear();
      found = tiles_.emplace(entry->id, std::move(rgba)).first;
    }
    const GeoBounds bounds = tile_bounds(entry->id);
    const auto part = [this](double share) {
      return std::clamp(static_cast<int>(share * size_), 0, size_ - 1);
    };
    const int column = part((place.lon - bounds.west) / bounds.width());
    const int row = part((bounds.north - place.lat) / bounds.height());
    return found->second.data() + 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) +
                                       static_cast<std::size_t>(column));
  }

 private:
  const PackReader& pack_;
  int size_;
  std::map<TileId, std::vector<std::uint8_t>> tiles_;
};

/// libjpeg's errors jump, so each call into it stands alone in a function that holds no objects.
struct JpegMemory {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf jump{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  char complaint[JMSG_LENGTH_MAX] = "libjpeg cannot start";

  ~JpegMemory() {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
  }
  [[noreturn]] static void keep_complaint(j_common_ptr common) {
    auto* memory = static_cast<JpegMemory*>(common->client_data);
    common->err->format_message(common, memory->complaint);
    std::longjmp(memory->jump, 1);
  }
  bool start(int side) {
    constexpr int kQuality = 90;
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = keep_complaint;
    errors.output_message = [](j_common_ptr) {};
    if (setjmp(jump) != 0) return false;
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &size);
    jpeg.image_width = jpeg.image_height = static_cast<JDIMENSION>(side);
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
};

}  // namespace

Result<ImageryView> draw_imagery(const PackReader& pack, const GeoBounds& bounds, int size) {
  const auto levels = pack.levels(Layer::imagery);
  const double pixel = bounds.height() / size;
  const int level =
      std::clamp(static_cast<int>(std::ceil(-std::log2(pixel * (pack.header().tile_size - 1)) - 1e-9)),
                 levels->coarsest, levels->finest);
  Texels texels(pack);
  ImageryView view;
  view.size = size;
  view.rgba.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * 4);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const LonLat place{bounds.west + bounds.width() * (c + 0.5) / size,
                         bounds.north - bounds.height() * (r + 0.5) / size};
      const auto texel = texels.at(place, level);
      if (!texel) return texel.error();
      static constexpr std::uint8_t kNothing[4] = {255, 255, 255, 0};
      const std::uint8_t* colour = *texel == nullptr ? kNothing : *texel;
      view.is_empty = view.is_empty && colour[3] == 0;
      view.rgba.insert(view.rgba.end(), colour, colour + 4);
    }
  }
  return view;
}

Result<std::vector<std::byte>> encode_jpeg(const ImageryView& view) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(view.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < view.rgba.size(); i += 4) {
    const unsigned alpha = view.rgba[i + 3];
    for (std::size_t k = 0; k < 3; ++k)
      rgb.push_back(static_cast<std::uint8_t>((view.rgba[i + k] * alpha + 255 * (255 - alpha) + 127) / 255));
  }
  const auto memory = std::make_unique<JpegMemory>();
  bool good = memory->start(view.size);
  for (int r = 0; r < view.size && good; ++r)
    good = memory->write(rgb.data() +
                         std::size_t{3} * static_cast<std::size_t>(r) * static_cast<std::size_t>(view.size));
  if (!good || !memory->end()) return failed(std::string("JPEG: ") + memory->complaint);
  const auto* bytes = reinterpret_cast<const std::byte*>(memory->bytes);
  return std::vector<std::byte>(bytes, bytes + memory->size);
}

}  // namespace cairn
