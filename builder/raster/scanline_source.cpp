#include "builder/raster/scanline_source.h"

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "builder/raster/height_tags.h"
#include "builder/raster/pam_sidecar.h"
#include "builder/raster/raster_placement.h"
#include "builder/raster/world_file.h"

namespace cairn {
namespace {

class ScanlineSource final : public RasterSource {
 public:
  ScanlineSource(RasterInfo info, const HeightEncoding& encoding, const ScanlineHeader& header,
                 DecodeRows decode, std::size_t cache_bytes)
      : RasterSource(std::move(info)),
        encoding_(encoding),
        header_(header),
        decode_(decode),
        pixels_(cache_bytes) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const override;

 private:
  Status decode_once() const;
  std::size_t pixel_bytes() const { return size_of(info_.type) * static_cast<std::size_t>(info_.bands); }
  Status read_row(const PostWindow& window, std::int64_t row, std::vector<std::byte>& pixels) const;

  HeightEncoding encoding_;
  ScanlineHeader header_;
  DecodeRows decode_;
  mutable std::once_flag once_;
  mutable Status decoded_;
  mutable ScratchBytes pixels_;
};

Status ScanlineSource::decode_once() const {
  std::call_once(once_, [this] {
    decoded_ =
        decode_(info_.path, header_, [this](std::span<const std::byte> row) { return pixels_.append(row); });
  });
  return decoded_;
}

Status ScanlineSource::read_row(const PostWindow& window, std::int64_t row,
                                std::vector<std::byte>& pixels) const {
  const std::int64_t first = (window.row + row) * info_.columns + window.column;
  pixels.resize(static_cast<std::size_t>(window.columns) * pixel_bytes());
  return pixels_.read_at(static_cast<std::uint64_t>(first) * pixel_bytes(), pixels);
}

Status ScanlineSource::read_heights(const PostWindow& window, std::span<float> out) const {
  if (info_.bands > 2 && !info_.overrides.band)
    return bad_data(info_.path.string() + ": expected heights, found an image in colours");
  if (auto decoded = decode_once(); !decoded) return decoded;
  const auto columns = static_cast<std::size_t>(window.columns),
             bands = static_cast<std::size_t>(info_.bands);
  const std::size_t at_band =
      static_cast<std::size_t>(info_.overrides.band.value_or(1) - 1) * size_of(info_.type);
  const HeightEncoding alpha_encoding{.type = info_.type};
  std::vector<std::byte> pixels;
  std::vector<float> alpha(columns, 1.0F);
  for (std::int64_t r = 0; r < window.rows; ++r) {
    if (auto read = read_row(window, r, pixels); !read) return read;
    float* at = out.data() + static_cast<std::size_t>(r) * columns;
    decode_heights(encoding_, pixels.data() + at_band, columns, bands, at);
    if (bands % 2 == 0)
      decode_heights(alpha_encoding, pixels.data() + (bands - 1) * size_of(info_.type), columns, bands,
                     alpha.data());
    for (std::size_t c = 0; c < columns; ++c)
      if (alpha[c] == 0) at[c] = std::numeric_limits<float>::quiet_NaN();
  }
  return {};
}

Status ScanlineSource::read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const {
  if (info_.type != SampleType::uint8 && info_.type != SampleType::uint16)
    return bad_data(info_.path.string() + ": image: expected samples of 8 or 16 bits, found " +
                    to_string(info_.type));
  if (auto decoded = decode_once(); !decoded) return decoded;
  const auto columns = static_cast<std::size_t>(window.columns),
             bands = static_cast<std::size_t>(info_.bands);
  ColourEncoding colours;
  colours.type = info_.type;
  colours.bits = info_.type == SampleType::uint8 ? 8 : 16;
  colours.range = said_range(info_.overrides, colours.bits);
  colours.channels = bands >= 3 ? std::vector{0, 1, 2} : std::vector{0};
  colours.nodata = info_.nodata;
  if (bands % 2 == 0) colours.alpha = info_.bands - 1;
  ColourAssembly assembly(colours, rgba);
  std::vector<std::byte> pixels;
  for (std::int64_t r = 0; r < window.rows; ++r) {
    if (auto read = read_row(window, r, pixels); !read) return read;
    for (std::size_t band = 0; band < bands; ++band)
      assembly.add(static_cast<int>(band), static_cast<std::size_t>(r) * columns, columns,
                   pixels.data() + band * size_of(info_.type), bands);
  }
  assembly.finish();
  return {};
}

}  // namespace

Result<std::unique_ptr<RasterSource>> open_scanline_raster(const char* format,
                                                           const std::filesystem::path& path,
                                                           const ScanlineHeader& header, DecodeRows decode,
                                                           const OpenOptions& options) {
  // GDAL reads what lies beside such a file besides a world file and a .prj.
  if (auto band = check_band(path, header.bands, options.overrides); !band) return band.error();
  const PamSidecar pam = read_pam_beside(path, options.overrides.band.value_or(1));
  std::error_code ignored;
  if (pam.places || std::filesystem::is_regular_file(std::filesystem::path(path).concat(".msk"), ignored))
    return bad_data(path.string() + ": expected no mask or georeference in a side-car, found one");
  HeightTags tags;
  apply_pam(pam, tags);
  std::optional<VerticalCrs> vertical;
  if (!options.overrides.crs) vertical = vertical_crs_beside(path);
  if (vertical) apply_vertical_crs(*vertical, tags);
  apply_overrides(options.overrides, tags);
  const auto encoding = height_encoding_of(path, header.type, tags);
  if (!encoding) return encoding.error();
  RasterInfo info;
  info.path = path;
  info.format = format;
  info.columns = header.columns;
  info.rows = header.rows;
  info.bands = header.bands;
  info.type = header.type;
  info.whole_metres = encoding->whole_metres();
  info.nodata = encoding->nodata;
  info.unit = tags.unit;
  if (vertical) info.vertical = vertical_reference(*vertical);
  info.overrides = options.overrides;
  const auto georeference = georeference_beside(path, info.columns, info.rows, options);
  if (!georeference) return georeference.error();
  info.georeference = *georeference;
  if (auto placed = place_raster(info); !placed) return placed.error();
  std::unique_ptr<RasterSource> source =
      std::make_unique<ScanlineSource>(std::move(info), *encoding, header, decode, options.cache_bytes);
  return source;
}

}  // namespace cairn
