#include "builder/export/texture_file.h"

#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "builder/export/png_writer.h"
#include "builder/texture_encode/texture_encode.h"
#include "format/block_texture.h"
#include "format/bytes.h"
#include "format/file.h"

namespace cairn {
namespace {

TextureTile one_colour_tile(std::int32_t colour, int size) {
  std::array<std::uint8_t, 4> rgba;
  std::memcpy(rgba.data(), &colour, 4);
  TextureTile tile{rgba[3] == 255 ? TextureFormat::bc1 : TextureFormat::bc3, size, {}};
  for (int side = size; side > 0; side /= 2) {
    std::vector<std::uint8_t> image;
    for (int i = 0; i < side * side; ++i) image.insert(image.end(), rgba.begin(), rgba.end());
    encode_texture(tile.format, TextureQuality::best, image, side, side, tile.texels);
  }
  return tile;
}

// "DDS file layout" and "DDS_HEADER", Microsoft.
constexpr std::uint32_t kCapsSizeFormatMipsLinear = 0x1 | 0x2 | 0x4 | 0x1000 | 0x20000 | 0x80000;
constexpr std::uint32_t kFourCc = 0x4;
constexpr std::uint32_t kComplexTextureMipmap = 0x8 | 0x1000 | 0x400000;
// Like DXT1 and DXT5 it does not say that the colours are sRGB; OpenImageIO 2.4 does not know the one that
// does (99).
constexpr std::uint32_t kBc7 = 98;
constexpr std::uint32_t kTexture2d = 3;

std::uint32_t four_cc(TextureFormat format) {
  const char* text = format == TextureFormat::bc1 ? "DXT1" : format == TextureFormat::bc3 ? "DXT5" : "DX10";
  std::uint32_t code = 0;
  std::memcpy(&code, text, 4);
  return code;
}

std::vector<std::byte> dds_header(const TextureTile& tile) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  const auto write = [&](std::uint32_t value) { out.write(value); };
  const auto zeros = [&](int count) {
    for (int i = 0; i < count; ++i) write(0);
  };
  const auto size = static_cast<std::uint32_t>(tile.size);
  out.append(std::as_bytes(std::span("DDS ", 4)));
  write(124);
  write(kCapsSizeFormatMipsLinear);
  write(size);
  write(size);
  write(static_cast<std::uint32_t>(texture_image_bytes(tile.format, tile.size)));
  write(0);
  write(static_cast<std::uint32_t>(std::bit_width(size)));
  zeros(11);
  write(32);
  write(kFourCc);
  write(four_cc(tile.format));
  zeros(5);
  write(kComplexTextureMipmap);
  zeros(4);
  if (tile.format == TextureFormat::bc7) {
    write(kBc7);
    write(kTexture2d);
    write(0);
    write(1);
    write(0);
  }
  return bytes;
}

}  // namespace

Result<TextureTile> read_texture_tile(const PackReader& pack, const IndexEntry& entry) {
  const int size = pack.header().tile_size - 1;
  if ((entry.flags & kConstant) != 0) return one_colour_tile(entry.min_quanta, size);
  const auto block = pack.read_block(entry);
  if (!block) return block.error();
  auto tile = decode_texture_block(*block, size);
  if (!tile)
    return bad_data(pack.path().string() + ": imagery " + to_string(entry.id) + ": " + tile.error().message);
  return tile;
}

Status write_texture_dds(const std::filesystem::path& target, const TextureTile& tile) {
  const auto part = std::filesystem::path(target).concat(".part");
  auto file = File::open_to_write(part);
  if (!file) return file.error();
  if (auto status = file->truncate(0); !status) return status;
  const std::vector<std::byte> header = dds_header(tile);
  if (auto status = file->write(0, header); !status) return status;
  if (auto status = file->write(header.size(), tile.texels); !status) return status;
  return rename_durably(part, target);
}

Status write_texture_png(const std::filesystem::path& target, const TextureTile& tile) {
  const auto size = static_cast<std::size_t>(tile.size);
  std::vector<std::uint8_t> rgba(4 * size * size);
  const auto first = std::span(tile.texels).first(texture_image_bytes(tile.format, tile.size));
  if (auto status = decode_texture(tile.format, first, tile.size, tile.size, rgba); !status) return status;
  auto picture = PngWriter::create(target, tile.size, tile.size, PngWriter::Pixel::rgba8);
  if (!picture) return picture.error();
  for (std::size_t r = 0; r < size; ++r) {
    if (auto status = picture->write_row(std::as_bytes(std::span(rgba).subspan(4 * size * r, 4 * size)));
        !status)
      return status;
  }
  return picture->finish();
}

}  // namespace cairn
