// Image formats that the other readers do not know, through OpenImageIO: JPEG 2000, BMP, WebP, OpenEXR, TGA …
// Samples keep their own type, since OpenImageIO scales integers to 0…1 when it is asked for floats.
#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <string>

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "builder/raster/image_module.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

std::string reason_of(const OIIO::ImageInput* image) {
  std::string text = image != nullptr ? image->geterror() : OIIO::geterror();
  text = text.substr(0, text.find('\n'));
  return text.empty() ? "damaged data" : text;
}

Result<std::unique_ptr<OIIO::ImageInput>> open_image(const fs::path& path) {
  OIIO::ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> image = OIIO::ImageInput::open(path.string(), &wanted);
  if (image) return image;
  return bad_data(path.string() + ": expected an image, found: " + reason_of(nullptr));
}

struct NativeType {
  SampleType type;
  OIIO::TypeDesc read_as;
};

std::optional<NativeType> native_type(const OIIO::TypeDesc& format) {
  switch (format.basetype) {
    case OIIO::TypeDesc::UINT8:
      return NativeType{SampleType::uint8, OIIO::TypeDesc::UINT8};
    case OIIO::TypeDesc::UINT16:
      return NativeType{SampleType::uint16, OIIO::TypeDesc::UINT16};
    case OIIO::TypeDesc::INT16:
      return NativeType{SampleType::int16, OIIO::TypeDesc::INT16};
    case OIIO::TypeDesc::UINT32:
      return NativeType{SampleType::uint32, OIIO::TypeDesc::UINT32};
    case OIIO::TypeDesc::INT32:
      return NativeType{SampleType::int32, OIIO::TypeDesc::INT32};
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      return NativeType{SampleType::float32, OIIO::TypeDesc::FLOAT};
    default:
      return std::nullopt;
  }
}

Result<ScanlineHeader> header_of(const fs::path& path, const OIIO::ImageSpec& spec) {
  const auto native = native_type(spec.format);
  if (!native || spec.nchannels < 1 || spec.nchannels > 4 || spec.depth > 1 || spec.width < 1 ||
      spec.height < 1)
    return bad_data(
        fmt::format("{}: image: expected 1 to 4 channels of a type that cairn knows, found {} of {}",
                    path.string(), spec.nchannels, spec.format.c_str()));
  return ScanlineHeader{spec.width, spec.height, spec.nchannels, native->type};
}

Result<ScanlineHeader> read_header(const fs::path& path) {
  try {
    const auto image = open_image(path);
    if (!image) return image.error();
    return header_of(path, (*image)->spec());
  } catch (const std::exception& e) {
    return bad_data(path.string() + ": expected an image, found: " + e.what());
  }
}

Status read_rows(const fs::path& path, OIIO::ImageInput& image, const RowSink& sink) {
  const OIIO::ImageSpec& spec = image.spec();
  const OIIO::TypeDesc type = native_type(spec.format)->read_as;
  const int band = spec.tile_width > 0 ? spec.tile_height : 1;
  const std::size_t row_bytes =
      type.size() * static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
  std::vector<std::byte> rows(row_bytes * static_cast<std::size_t>(band));
  for (int top = 0; top < spec.height; top += band) {
    const int count = std::min(band, spec.height - top), y = spec.y + top;
    const bool read =
        spec.tile_width > 0
            ? image.read_tiles(0, 0, spec.x, spec.x + spec.width, y, y + count, 0, 1, 0, spec.nchannels, type,
                               rows.data(), OIIO::AutoStride, static_cast<OIIO::stride_t>(row_bytes))
            : image.read_scanlines(0, 0, y, y + count, 0, 0, spec.nchannels, type, rows.data());
    if (!read)
      return bad_data(
          fmt::format("{}: row {}: expected pixels, found: {}", path.string(), top, reason_of(&image)));
    for (int r = 0; r < count; ++r) {
      if (auto kept = sink(std::span(rows).subspan(static_cast<std::size_t>(r) * row_bytes, row_bytes));
          !kept)
        return kept;
    }
  }
  return {};
}

Status decode(const fs::path& path, const ScanlineHeader& expected, const RowSink& sink) {
  try {
    const auto image = open_image(path);
    if (!image) return image.error();
    const auto header = header_of(path, (*image)->spec());
    if (!header) return header.error();
    if (header->columns != expected.columns || header->rows != expected.rows ||
        header->bands != expected.bands || header->type != expected.type)
      return bad_data(path.string() + ": image: expected it unchanged since it was opened, found another");
    return read_rows(path, **image, sink);
  } catch (const std::exception& e) {
    return bad_data(path.string() + ": expected an image, found: " + e.what());
  }
}

}  // namespace
}  // namespace cairn

/// The module's one entry.
extern "C" __attribute__((visibility("default"))) void cairn_image_module(cairn::ImageModule& out) {
  out = {cairn::read_header, cairn::decode};
}
