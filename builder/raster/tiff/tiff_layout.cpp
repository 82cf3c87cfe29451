#include "builder/raster/tiff/tiff_layout.h"

#include <limits>
#include <string>

#include <fmt/format.h>
#include <tiffio.h>

#include "builder/raster/tiff/gdal_metadata.h"

namespace cairn {
namespace {

constexpr std::int64_t kMostChunkBytes = std::int64_t{1} << 40;

template <class T>
T tag_or_default(const TiffHandle& handle, std::uint32_t tag, T otherwise) {
  T value{};
  return TIFFGetFieldDefaulted(handle.get(), tag, &value) == 1 ? value : otherwise;
}

std::optional<SampleType> sample_type(int bits, int format) {
  if (format == SAMPLEFORMAT_IEEEFP) {
    if (bits == 32) return SampleType::float32;
    if (bits == 64) return SampleType::float64;
    return std::nullopt;
  }
  const bool is_signed = format == SAMPLEFORMAT_INT;
  switch (bits) {
    case 1:
    case 2:
    case 4:
      return is_signed ? std::nullopt : std::optional(SampleType::uint8);
    case 8:
      return is_signed ? SampleType::int8 : SampleType::uint8;
    case 16:
      return is_signed ? SampleType::int16 : SampleType::uint16;
    case 32:
      return is_signed ? SampleType::int32 : SampleType::uint32;
    default:
      return std::nullopt;
  }
}

std::vector<std::uint8_t> palette_of(const TiffHandle& handle, int bits) {
  std::uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
  if (bits > 8 || TIFFGetField(handle.get(), TIFFTAG_COLORMAP, &red, &green, &blue) != 1) return {};
  std::vector<std::uint8_t> palette;
  for (std::size_t i = 0; i < std::size_t{1} << bits; ++i)
    for (const std::uint16_t* channel : {red, green, blue})
      palette.push_back(static_cast<std::uint8_t>(channel[i] >> 8));
  return palette;
}

/// A writer that knew no better marks a fourth band as alpha though it is near infrared; where GDAL then
/// notes what the bands are, that holds.
void believe_gdal(const TiffHandle& handle, TiffLayout& layout) {
  const std::string metadata = handle.ascii(kGdalMetadataTag);
  const int colours = layout.bands - static_cast<int>(layout.extra_samples.size());
  for (std::size_t i = 0; i < layout.extra_samples.size(); ++i) {
    const auto kind = gdal_metadata_item(metadata, "colorinterp", colours + static_cast<int>(i));
    if (kind && *kind != "Alpha") layout.extra_samples[i] = EXTRASAMPLE_UNSPECIFIED;
  }
  for (const std::string_view colour : {"Red", "Green", "Blue"}) {
    for (int band = 0; band < layout.bands; ++band)
      if (gdal_metadata_item(metadata, "colorinterp", band) == colour) {
        layout.red_green_blue.push_back(band);
        break;
      }
  }
  if (layout.red_green_blue.size() != 3) layout.red_green_blue.clear();
}

Status read_samples(const std::filesystem::path& path, const TiffHandle& handle, TiffLayout& layout) {
  const auto bad = [&](const std::string& what) { return bad_data(path.string() + ": TIFF tags: " + what); };
  layout.bands = tag_or_default<std::uint16_t>(handle, TIFFTAG_SAMPLESPERPIXEL, 1);
  layout.bits = tag_or_default<std::uint16_t>(handle, TIFFTAG_BITSPERSAMPLE, 1);
  const int format = tag_or_default<std::uint16_t>(handle, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const auto type = sample_type(layout.bits, format);
  if (!type || layout.bands < 1)
    return bad(
        fmt::format("expected integer samples of 1, 2, 4, 8, 16 or 32 bits or floating of 32 or 64, found "
                    "{} × {} bits, sample format {}",
                    layout.bands, layout.bits, format));
  layout.type = *type;
  layout.planar = layout.bands > 1 &&
                  tag_or_default<std::uint16_t>(handle, TIFFTAG_PLANARCONFIG, 1) == PLANARCONFIG_SEPARATE;
  layout.compression = tag_or_default<std::uint16_t>(handle, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (TIFFIsCODECConfigured(layout.compression) == 0)
    return bad(fmt::format("expected a compression that libtiff has, found number {}", layout.compression));
  layout.photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(handle.get(), TIFFTAG_PHOTOMETRIC, &layout.photometric);
  std::uint16_t extra_count = 0;
  const std::uint16_t* extra = nullptr;
  if (TIFFGetField(handle.get(), TIFFTAG_EXTRASAMPLES, &extra_count, &extra) == 1)
    layout.extra_samples.assign(extra, extra + extra_count);
  believe_gdal(handle, layout);
  if (layout.photometric == PHOTOMETRIC_PALETTE) layout.palette = palette_of(handle, layout.bits);
  return {};
}

Status read_chunks(const std::filesystem::path& path, const TiffHandle& handle, TiffLayout& layout) {
  const auto bad = [&](const std::string& what) { return bad_data(path.string() + ": TIFF tags: " + what); };
  layout.tiled = TIFFIsTiled(handle.get()) != 0;
  layout.chunk_columns = layout.columns;
  layout.chunk_rows = std::min<std::int64_t>(
      layout.rows, tag_or_default<std::uint32_t>(handle, TIFFTAG_ROWSPERSTRIP, 0xFFFFFFFFu));
  if (layout.tiled) {
    layout.chunk_columns = tag_or_default<std::uint32_t>(handle, TIFFTAG_TILEWIDTH, 0);
    layout.chunk_rows = tag_or_default<std::uint32_t>(handle, TIFFTAG_TILELENGTH, 0);
  }
  if (layout.chunk_columns <= 0 || layout.chunk_rows <= 0)
    return bad(fmt::format("expected strips or tiles, found {}×{}", layout.chunk_columns, layout.chunk_rows));
  if (packed_row_bytes(layout) > kMostChunkBytes / layout.chunk_rows)
    return bad(fmt::format("expected strips or tiles that fit a file, found {}×{} pixels",
                           layout.chunk_columns, layout.chunk_rows));
  const std::int64_t chunks =
      layout.chunks_across() * layout.chunks_down() * (layout.planar ? layout.bands : 1);
  const std::int64_t declared =
      layout.tiled ? TIFFNumberOfTiles(handle.get()) : TIFFNumberOfStrips(handle.get());
  if (chunks != declared) return bad(fmt::format("expected {} strips or tiles, found {}", chunks, declared));
  return {};
}

}  // namespace

Result<TiffLayout> read_tiff_layout(const std::filesystem::path& path, const TiffHandle& handle) {
  TiffLayout layout;
  layout.columns = tag_or_default<std::uint32_t>(handle, TIFFTAG_IMAGEWIDTH, 0);
  layout.rows = tag_or_default<std::uint32_t>(handle, TIFFTAG_IMAGELENGTH, 0);
  if (layout.columns == 0 || layout.rows == 0 || layout.columns > std::numeric_limits<std::int32_t>::max() ||
      layout.rows > std::numeric_limits<std::int32_t>::max())
    return bad_data(fmt::format("{}: TIFF tags: expected 1 to 2^31 - 1 pixels each way, found {}×{}",
                                path.string(), layout.columns, layout.rows));
  if (auto samples = read_samples(path, handle, layout); !samples) return samples.error();
  if (auto chunks = read_chunks(path, handle, layout); !chunks) return chunks.error();
  return layout;
}

std::int64_t packed_row_bytes(const TiffLayout& layout) {
  return (layout.chunk_columns * layout.samples_together() * layout.bits + 7) / 8;
}

std::vector<std::byte> unpack_bits(const TiffLayout& layout, std::span<const std::byte> packed) {
  const auto row_bytes = static_cast<std::size_t>(packed_row_bytes(layout));
  const auto row_samples = static_cast<std::size_t>(layout.chunk_columns * layout.samples_together());
  const auto bits = static_cast<unsigned>(layout.bits);
  const unsigned per_byte = 8 / bits, mask = (1u << bits) - 1;
  const std::size_t rows = packed.size() / row_bytes;
  std::vector<std::byte> samples(rows * row_samples);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t i = 0; i < row_samples; ++i) {
      const auto byte = std::to_integer<unsigned>(packed[r * row_bytes + i / per_byte]);
      const auto shift = 8 - bits * static_cast<unsigned>(i % per_byte + 1);
      samples[r * row_samples + i] = static_cast<std::byte>(byte >> shift & mask);
    }
  return samples;
}

}  // namespace cairn
