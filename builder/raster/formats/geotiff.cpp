// GeoTIFF, BigTIFF and plain TIFF with a world file: strips or tiles, any compression that libtiff has, posts
// in their own type.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tiffio.h>

#include "builder/raster/height_tags.h"
#include "builder/raster/pam_sidecar.h"
#include "builder/raster/raster_names.h"
#include "builder/raster/raster_placement.h"
#include "builder/raster/raster_source.h"
#include "builder/raster/tiff/geotiff_tags.h"
#include "builder/raster/tiff/tiff_colours.h"
#include "builder/raster/tiff/tiff_image.h"
#include "builder/raster/world_file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".tif", ".tiff", ".gtiff", ".tf8", ".btf"};

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();
constexpr int kMostDirectories = 64;

/// The directory that holds a transparency mask for the first one (TIFF 6.0, NewSubfileType bit 2).
std::optional<std::uint16_t> mask_directory(TIFF* tiff) {
  std::optional<std::uint16_t> found;
  for (std::uint16_t i = 1; i < kMostDirectories && !found && TIFFReadDirectory(tiff) == 1; ++i) {
    std::uint32_t kind = 0;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &kind);
    if (kind == FILETYPE_MASK) found = i;
  }
  TIFFSetDirectory(tiff, 0);
  return found;
}

class GeoTiffSource final : public RasterSource {
 public:
  GeoTiffSource(RasterInfo info, Result<HeightEncoding> encoding, std::unique_ptr<TiffImage> image,
                std::unique_ptr<TiffImage> mask)
      : RasterSource(std::move(info)),
        encoding_(std::move(encoding)),
        image_(std::move(image)),
        mask_(std::move(mask)) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const override;

 private:
  Status check_heights() const;
  Status visit_absent(const PostWindow& window, const std::function<void(std::size_t)>& absent) const;

  Result<HeightEncoding> encoding_;  // an error matters to heights only: an image has any unit
  std::unique_ptr<TiffImage> image_;
  std::unique_ptr<TiffImage> mask_;  // null where there is none
};

Status GeoTiffSource::check_heights() const {
  if (info_.overrides.band) return {};  // the user knows what that band is
  const std::uint16_t photometric = image_->layout().photometric;
  if (photometric == PHOTOMETRIC_MINISBLACK || photometric == PHOTOMETRIC_MINISWHITE) return {};
  return bad_data(info_.path.string() + ": expected heights, found an image in colours");
}

/// Calls back with the place in the window of each pixel that an alpha band or a mask leaves out.
Status GeoTiffSource::visit_absent(const PostWindow& window,
                                   const std::function<void(std::size_t)>& absent) const {
  const auto visit = [&](const TiffImage& image, int sample) {
    const TiffLayout& layout = image.layout();
    const std::size_t bytes = size_of(layout.type);
    const std::size_t step = bytes * static_cast<std::size_t>(layout.samples_together());
    const std::size_t at = layout.planar ? 0 : static_cast<std::size_t>(sample) * bytes;
    return image.visit(window, layout.planar ? sample : 0, [&](const TiffImage::Run& run) {
      for (std::int64_t i = 0; i < run.count; ++i) {
        const std::byte* alpha = run.samples + static_cast<std::size_t>(i) * step + at;
        const bool zero = run.samples == nullptr ||
                          std::all_of(alpha, alpha + bytes, [](std::byte b) { return b == std::byte{0}; });
        if (zero) absent(static_cast<std::size_t>(run.row * window.columns + run.column + i));
      }
    });
  };
  if (const auto alpha = alpha_sample_of(image_->layout())) {
    if (auto visited = visit(*image_, *alpha); !visited) return visited;
  }
  return mask_ ? visit(*mask_, 0) : Status();
}

Status GeoTiffSource::read_heights(const PostWindow& window, std::span<float> out) const {
  if (auto heights = check_heights(); !heights) return heights;
  if (!encoding_) return encoding_.error();
  const auto width = static_cast<std::size_t>(window.columns);
  const TiffLayout& layout = image_->layout();
  const auto stride = static_cast<std::size_t>(layout.samples_together());
  const int band = info_.overrides.band.value_or(1) - 1;
  const std::size_t at_band = layout.planar ? 0 : static_cast<std::size_t>(band) * size_of(layout.type);
  const float unstored = encoding_->nodata ? kVoid : 0.0F;
  const Status read = image_->visit(window, layout.planar ? band : 0, [&](const TiffImage::Run& run) {
    float* at = out.data() + static_cast<std::size_t>(run.row) * width + run.column;
    const auto count = static_cast<std::size_t>(run.count);
    if (run.samples == nullptr) {
      std::fill_n(at, count, unstored);
    } else {
      decode_heights(*encoding_, run.samples + at_band, count, stride, at);
    }
  });
  if (!read) return read;
  return visit_absent(window, [&](std::size_t i) { out[i] = kVoid; });
}

Status GeoTiffSource::read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const {
  auto encoding = colours_of_tiff(image_->layout(), info_.nodata, info_.path);
  if (!encoding) return encoding.error();
  encoding->range = said_range(info_.overrides, encoding->bits);
  if (auto read = read_tiff_colours(*image_, *encoding, window, rgba); !read) return read;
  if (!mask_) return {};
  return visit_absent(window, [&](std::size_t i) { rgba[4 * i + 3] = 0; });
}

bool claims(const fs::path&, std::span<const std::byte> first) {
  if (first.size() < 4) return false;
  const auto at = [&](std::size_t i) { return std::to_integer<int>(first[i]); };
  const bool little = at(0) == 'I' && at(1) == 'I' && (at(2) == 42 || at(2) == 43) && at(3) == 0;
  const bool big = at(0) == 'M' && at(1) == 'M' && at(2) == 0 && (at(3) == 42 || at(3) == 43);
  return little || big;
}

/// By the tags; by a world file or bounds where the tags say no place; by a .prj where they say no CRS.
Result<Georeference> find_place(const GeoTiffTags& tags, const TiffLayout& layout, const fs::path& path,
                                const OpenOptions& options) {
  if (tags.has_place() && tags.has_crs()) return georeference_of(tags, path);
  if (!tags.has_place() && !tags.has_crs())
    return georeference_beside(path, layout.columns, layout.rows, options);
  if (tags.has_place()) {
    auto place = georeference_of(tags, path);
    if (!place) return place;
    if (auto prj = read_prj_beside(path, *place); !prj) return prj.error();
    return place;
  }
  Georeference crs;
  if (auto read = read_crs(tags, path, crs); !read) return read.error();
  return place_beside(path, layout.columns, layout.rows, options, crs);
}

Result<std::unique_ptr<TiffImage>> open_mask_directory(const fs::path& path, std::uint16_t directory,
                                                       const TiffLayout& layout, const OpenOptions& options) {
  auto handle = TiffHandle::open(path, directory);
  if (!handle) return handle.error();
  auto mask = TiffImage::open(path, std::move(*handle), directory, options.cache_bytes / 8);
  if (!mask) return mask.error();
  if ((*mask)->layout().columns != layout.columns || (*mask)->layout().rows != layout.rows)
    return bad_data(fmt::format("{}: mask: expected the image's size, {}×{}, found {}×{}", path.string(),
                                layout.columns, layout.rows, (*mask)->layout().columns,
                                (*mask)->layout().rows));
  return mask;
}

/// The mask in the file itself, else that in FILE.msk, as GDAL writes it beside the file; null where there is
/// none.
Result<std::unique_ptr<TiffImage>> open_mask(const fs::path& path, const TiffLayout& layout,
                                             bool has_more_directories, const OpenOptions& options) {
  if (has_more_directories) {
    const auto handle = TiffHandle::open(path, 0);
    if (!handle) return handle.error();
    if (const auto directory = mask_directory((*handle)->get()))
      return open_mask_directory(path, *directory, layout, options);
  }
  const fs::path beside = fs::path(path).concat(".msk");
  std::error_code ignored;
  if (!fs::is_regular_file(beside, ignored)) return std::unique_ptr<TiffImage>();
  return open_mask_directory(beside, 0, layout, options);
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  auto handle = TiffHandle::open(path, 0);
  if (!handle) return handle.error();
  GeoTiffTags tags = read_geotiff_tags(**handle);
  const bool has_more_directories = TIFFLastDirectory((*handle)->get()) == 0;
  auto image = TiffImage::open(path, std::move(*handle), 0, options.cache_bytes);
  if (!image) return image.error();
  const TiffLayout& layout = (*image)->layout();
  if (auto band = check_band(path, layout.bands, options.overrides); !band) return band.error();
  const int band = options.overrides.band.value_or(1);
  if (options.overrides.crs) drop_crs(tags);
  const PamSidecar pam = read_pam_beside(path, band);
  if (pam.places)  // GDAL reads it
    return bad_data(path.string() + ".aux.xml: expected no georeference beside a GeoTIFF, found one");
  const auto georeference = find_place(tags, layout, path, options);
  if (!georeference) return georeference.error();
  HeightTags height = height_tags_of(tags, band);
  apply_pam(pam, height);
  std::optional<VerticalCrs> vertical;
  if (!tags.has_crs() && !options.overrides.crs) vertical = vertical_crs_beside(path);
  if (vertical) apply_vertical_crs(*vertical, height);
  apply_overrides(options.overrides, height);
  auto encoding = height_encoding_of(path, layout.type, height);
  auto mask = open_mask(path, layout, has_more_directories, options);
  if (!mask) return mask.error();
  RasterInfo info;
  info.path = path;
  info.format = "geotiff";
  info.columns = layout.columns;
  info.rows = layout.rows;
  info.bands = layout.bands;
  info.type = layout.type;
  info.whole_metres = encoding && encoding->whole_metres();
  info.georeference = *georeference;
  info.nodata = height.nodata;
  info.unit = height.unit;
  info.vertical = vertical ? vertical_reference(*vertical) : vertical_reference_of(tags);
  info.overrides = options.overrides;
  if (auto placed = place_raster(info); !placed) return placed.error();
  std::unique_ptr<RasterSource> source = std::make_unique<GeoTiffSource>(std::move(info), std::move(encoding),
                                                                         std::move(*image), std::move(*mask));
  return source;
}

}  // namespace

extern const RasterFormat geotiff_format;
const RasterFormat geotiff_format = {"geotiff", 30, claims, open};

extern const RasterNames geotiff_names;
const RasterNames geotiff_names = {kExtensions};

}  // namespace cairn
