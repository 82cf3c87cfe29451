// GeoTIFF and BigTIFF: strips or tiles, any compression that libtiff has, posts in their own type.
#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <tiffio.h>

#include "builder/geotiff_tags.h"
#include "builder/height_encoding.h"
#include "builder/raster_placement.h"
#include "builder/raster_source.h"
#include "builder/tiff_image.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

class GeoTiffSource final : public RasterSource {
 public:
  GeoTiffSource(RasterInfo info, HeightEncoding encoding, std::unique_ptr<TiffImage> image)
      : RasterSource(std::move(info)), encoding_(encoding), image_(std::move(image)) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const override;

 private:
  HeightEncoding encoding_;
  std::unique_ptr<TiffImage> image_;
};

Status GeoTiffSource::read_heights(const PostWindow& window, std::span<float> out) const {
  const auto width = static_cast<std::size_t>(window.columns);
  const auto stride = static_cast<std::size_t>(image_->layout().samples_together());
  const float unstored = encoding_.nodata ? std::numeric_limits<float>::quiet_NaN() : 0.0F;
  return image_->visit(window, 0, [&](const TiffImage::Run& run) {
    float* at = out.data() + static_cast<std::size_t>(run.row) * width + run.column;
    const auto count = static_cast<std::size_t>(run.count);
    if (run.samples == nullptr) {
      std::fill_n(at, count, unstored);
    } else {
      decode_heights(encoding_, run.samples, count, stride, at);
    }
  });
}

Status GeoTiffSource::read_colours(const PostWindow&, std::span<std::uint8_t>) const {
  return bad_data(info_.path.string() + ": expected an image");
}

bool claims(const fs::path&, std::span<const std::byte> first) {
  if (first.size() < 4) return false;
  const auto at = [&](std::size_t i) { return std::to_integer<int>(first[i]); };
  const bool little = at(0) == 'I' && at(1) == 'I' && (at(2) == 42 || at(2) == 43) && at(3) == 0;
  const bool big = at(0) == 'M' && at(1) == 'M' && at(2) == 0 && (at(3) == 42 || at(3) == 43);
  return little || big;
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  const auto handle = TiffHandle::open(path, 0);
  if (!handle) return handle.error();
  auto image = TiffImage::open(path, **handle, 0, options.cache_bytes);
  if (!image) return image.error();
  const TiffLayout& layout = (*image)->layout();
  const GeoTiffTags tags = read_geotiff_tags(**handle);
  const auto georeference = georeference_of(tags, path);
  if (!georeference) return georeference.error();
  const auto scale = height_scale_of(tags, path);
  if (!scale) return scale.error();
  const HeightEncoding encoding{
      .type = layout.type, .nodata = nodata_of(tags), .scale = scale->scale, .offset = scale->offset};
  RasterInfo info;
  info.path = path;
  info.format = "geotiff";
  info.columns = layout.columns;
  info.rows = layout.rows;
  info.bands = layout.bands;
  info.type = layout.type;
  info.whole_metres = encoding.whole_metres();
  info.georeference = *georeference;
  info.nodata = encoding.nodata;
  if (auto placed = place_raster(info); !placed) return placed.error();
  std::unique_ptr<RasterSource> source =
      std::make_unique<GeoTiffSource>(std::move(info), encoding, std::move(*image));
  return source;
}

}  // namespace

extern const RasterFormat geotiff_format;
const RasterFormat geotiff_format = {"geotiff", 30, claims, open};

}  // namespace cairn
