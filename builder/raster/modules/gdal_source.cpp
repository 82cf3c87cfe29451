// What the other readers cannot open, through GDAL: VRT, ASCII grids, ENVI, netCDF … Posts are read as they
// are stored; GDAL says the CRS and the place of the raster in it, and warps nothing.
#include <cstdlib>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include "builder/raster/colour_encoding.h"
#include "builder/raster/crs.h"
#include "builder/raster/height_tags.h"
#include "builder/raster/modules/gdal_session.h"
#include "builder/raster/raster_placement.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr GIntBig kCacheBytes =
    16 << 20;  // of all datasets together; builder/bake/memory_budget.cpp counts it

std::string found() {
  const std::string reason = Quiet::reason();
  return reason.empty() ? "nothing that GDAL opens" : reason;
}

std::optional<SampleType> sample_type(GDALRasterBandH band) {
  switch (GDALGetRasterDataType(band)) {
    case GDT_Byte: {
      const char* kind = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
      return kind != nullptr && EQUAL(kind, "SIGNEDBYTE") ? SampleType::int8 : SampleType::uint8;
    }
    case GDT_UInt16:
      return SampleType::uint16;
    case GDT_Int16:
      return SampleType::int16;
    case GDT_UInt32:
      return SampleType::uint32;
    case GDT_Int32:
      return SampleType::int32;
    case GDT_Float32:
      return SampleType::float32;
    case GDT_Float64:
      return SampleType::float64;
    default:
      return std::nullopt;
  }
}

/// Whether the CRS is one of cairn's, and then sets it. A raster without CRS is taken as geographic.
bool set_known_crs(GDALDatasetH dataset, Georeference& g) {
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr) return true;
  const bool projected = OSRIsProjected(crs) != 0;
  const char* part = projected ? "PROJCS" : "GEOGCS";
  if (!projected && OSRIsGeographic(crs) == 0) return false;
  if (projected && OSRGetLinearUnits(crs, nullptr) != 1) return false;
  if (const char* code = OSRGetAuthorityCode(crs, part)) return set_crs(g, std::atoi(code));
  constexpr double kDegree = 0.017453292519943295;
  if (OSRGetPrimeMeridian(crs, nullptr) != 0 || std::abs(OSRGetAngularUnits(crs, nullptr) - kDegree) > 1e-12)
    return false;
  const char* datum = OSRGetAuthorityCode(crs, "DATUM");
  const char* name = OSRGetAttrValue(crs, "DATUM", 0);
  const bool near =
      (datum != nullptr && is_near_wgs84(std::atoi(datum))) || (name != nullptr && EQUAL(name, "WGS_1984"));
  int north = 0;
  const int zone = projected ? OSRGetUTMZone(crs, &north) : 0;
  return near && (projected ? set_utm(g, zone, north != 0) : true);
}

/// The CRS as WKT, for PROJ. A raster's own order of axes is east, north, whatever the CRS says.
bool set_crs_by_wkt(GDALDatasetH dataset, Georeference& g) {
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* text = nullptr;
  const bool exported =
      OSRExportToWktEx(GDALGetSpatialRef(dataset), &text, options) == OGRERR_NONE && text != nullptr;
  if (exported) set_other_crs(g, text);
  CPLFree(text);
  return exported;
}

void place_by_transform(const double* t, Georeference& g) {
  g.dx = t[1];
  g.x_per_row = t[2];
  g.y_per_column = t[4];
  g.dy = t[5];
  g.x0 = t[0] + (t[1] + t[2]) / 2;
  g.y0 = t[3] + (t[4] + t[5]) / 2;
}

struct Opened {
  Dataset dataset;
  Georeference georeference;
};

Result<Opened> open_dataset(const fs::path& path) {
  Opened opened;
  opened.dataset.reset(
      GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  GDALDatasetH dataset = opened.dataset.get();
  if (dataset == nullptr || GDALGetRasterCount(dataset) < 1)
    return bad_data(path.string() + ": expected a raster, found: " + found());
  double transform[6];
  if (GDALGetGeoTransform(dataset, transform) != CE_None)
    return bad_data(path.string() + ": georeference: expected one, found none");
  place_by_transform(transform, opened.georeference);
  if (set_known_crs(dataset, opened.georeference) || set_crs_by_wkt(dataset, opened.georeference))
    return opened;
  return bad_data(path.string() + ": CRS: expected one that can be written as WKT, found: " + found());
}

class GdalSource final : public RasterSource {
 public:
  GdalSource(RasterInfo info, Opened opened, Result<HeightEncoding> encoding, ColourEncoding colours)
      : RasterSource(std::move(info)),
        opened_(std::move(opened)),
        encoding_(std::move(encoding)),
        colours_(std::move(colours)) {}

  Status read_heights(const PostWindow& window, std::span<float> out) const override;
  Status read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const override;

 private:
  Status read_band(GDALRasterBandH band, const PostWindow& window, GDALDataType type, void* out) const;
  Status apply_mask(const PostWindow& window, const std::function<void(std::size_t)>& absent) const;

  Opened opened_;
  Result<HeightEncoding> encoding_;  // an error matters to heights only: an image has any unit
  ColourEncoding colours_;
  mutable std::mutex mutex_;  // a GDAL dataset serves one thread at a time
};

Status GdalSource::read_band(GDALRasterBandH band, const PostWindow& w, GDALDataType type, void* out) const {
  const auto columns = static_cast<int>(w.columns), rows = static_cast<int>(w.rows);
  if (GDALRasterIO(band, GF_Read, static_cast<int>(w.column), static_cast<int>(w.row), columns, rows, out,
                   columns, rows, type, 0, 0) == CE_None)
    return {};
  return bad_data(fmt::format("{}: column {}, row {}: expected posts, found: {}", info_.path.string(),
                              w.column, w.row, found()));
}

/// Calls back for pixels that a mask or an alpha band leaves out.
Status GdalSource::apply_mask(const PostWindow& window,
                              const std::function<void(std::size_t)>& absent) const {
  GDALRasterBandH band = GDALGetRasterBand(opened_.dataset.get(), 1);
  if ((GDALGetMaskFlags(band) & GMF_PER_DATASET) == 0) return {};
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(window.columns * window.rows));
  if (auto read = read_band(GDALGetMaskBand(band), window, GDT_Byte, mask.data()); !read) return read;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i] == 0) absent(i);
  return {};
}

Status GdalSource::read_heights(const PostWindow& window, std::span<float> out) const {
  if (!encoding_) return encoding_.error();
  const Quiet quiet;
  const std::lock_guard lock(mutex_);
  GDALRasterBandH band = GDALGetRasterBand(opened_.dataset.get(), info_.overrides.band.value_or(1));
  std::vector<std::byte> samples(static_cast<std::size_t>(window.columns * window.rows) *
                                 size_of(info_.type));
  if (auto read = read_band(band, window, GDALGetRasterDataType(band), samples.data()); !read) return read;
  decode_heights(*encoding_, samples.data(), out.size(), 1, out.data());
  return apply_mask(window, [&](std::size_t i) { out[i] = std::numeric_limits<float>::quiet_NaN(); });
}

Status GdalSource::read_colours(const PostWindow& window, std::span<std::uint8_t> rgba) const {
  const Quiet quiet;
  const std::lock_guard lock(mutex_);
  if (info_.type != SampleType::uint8 && info_.type != SampleType::uint16)
    return bad_data(fmt::format("{}: image: expected samples of 8 or 16 bits, found {}", info_.path.string(),
                                to_string(info_.type)));
  ColourAssembly assembly(colours_, rgba);
  std::vector<std::byte> samples(rgba.size() / 4 * size_of(info_.type));
  for (const int channel : colours_.channels) {
    GDALRasterBandH band = GDALGetRasterBand(opened_.dataset.get(), channel + 1);
    if (auto read = read_band(band, window, GDALGetRasterDataType(band), samples.data()); !read) return read;
    assembly.add(channel, 0, rgba.size() / 4, samples.data(), 1);
  }
  assembly.finish();
  return apply_mask(window, [&](std::size_t i) { rgba[4 * i + 3] = 0; });
}

/// Metres of the unit in which a compound CRS counts heights: 0 where it counts downwards, 1 where the CRS
/// says nothing of heights.
double metres_of_vertical_part(GDALDatasetH dataset) {
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr || OSRIsCompound(crs) == 0) return 1;
  OGRAxisOrientation direction = OAO_Up;
  OSRGetAxis(crs, "VERT_CS", 0, &direction);
  return direction == OAO_Down ? 0 : OSRGetTargetLinearUnits(crs, "VERT_CS", nullptr);
}

/// Labels of planetary products (LOLA's of PDS3) give distances from the centre: the offset is the radius of
/// the sphere, above which the heights are. An ellipsoid has no one radius; such posts count as impossible.
void subtract_radius(GDALDatasetH dataset, HeightTags& tags) {
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr || tags.metres != 1) return;
  const double radius_m = OSRGetSemiMajor(crs, nullptr);
  const bool is_sphere = OSRGetSemiMinor(crs, nullptr) == radius_m;
  if (is_sphere && std::abs(tags.offset - radius_m) <= 1e-3 * radius_m) tags.offset -= radius_m;
}

/// Only few formats have units of bands; of the others it is the CRS that says it.
HeightTags height_tags_of(GDALDatasetH dataset, GDALRasterBandH band) {
  HeightTags tags;
  tags.unit = GDALGetRasterUnitType(band);
  tags.metres = tags.unit.empty() ? metres_of_vertical_part(dataset) : metres_of_unit(tags.unit);
  if (tags.metres == 0 && tags.unit.empty()) tags.unit = "depths";
  int has = 0;
  const double nodata = GDALGetRasterNoDataValue(band, &has);
  if (has != 0) tags.nodata = nodata;
  const double scale = GDALGetRasterScale(band, &has);
  if (has != 0 && scale != 0) tags.scale = scale;
  const double offset = GDALGetRasterOffset(band, &has);
  if (has != 0) tags.offset = offset;
  subtract_radius(dataset, tags);
  return tags;
}

/// What the heights are measured from: the vertical part of a compound CRS, or a geographic one in three
/// dimensions.
std::optional<VerticalReference> vertical_reference_of(GDALDatasetH dataset) {
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr) return std::nullopt;
  if (OSRIsCompound(crs) != 0) {
    if (const char* code = OSRGetAuthorityCode(crs, "VERT_CS")) return vertical_reference(std::atoi(code));
    const char* name = OSRGetAttrValue(crs, "VERT_CS", 0);
    return vertical_reference_named(name == nullptr ? "unnamed" : name);
  }
  if (OSRIsGeographic(crs) == 0 || OSRGetAxesCount(crs) != 3) return std::nullopt;
  const char* name = OSRGetName(crs);
  return VerticalReference{name == nullptr ? "unnamed" : name, VerticalDatum::ellipsoid};
}

/// GDAL takes no notice of a mask that does not fit, or fails once posts are read.
Status check_mask(GDALDatasetH dataset, const fs::path& path) {
  std::error_code ignored;
  const fs::path mask = fs::path(path).concat(".msk");
  GDALRasterBandH band = GDALGetRasterBand(dataset, 1), of_band = GDALGetMaskBand(band);
  const bool fits = (GDALGetMaskFlags(band) & GMF_PER_DATASET) != 0 &&
                    GDALGetRasterBandXSize(of_band) == GDALGetRasterBandXSize(band) &&
                    GDALGetRasterBandYSize(of_band) == GDALGetRasterBandYSize(band);
  if (fits || !fs::is_regular_file(mask, ignored)) return {};
  return bad_data(fmt::format("{}: mask: expected one of {}×{} posts, found one that does not fit",
                              mask.string(), GDALGetRasterXSize(dataset), GDALGetRasterYSize(dataset)));
}

std::vector<std::uint8_t> palette_of(GDALRasterBandH band) {
  GDALColorTableH table = GDALGetRasterColorTable(band);
  std::vector<std::uint8_t> palette;
  if (table == nullptr) return palette;
  for (int i = 0; i < GDALGetColorEntryCount(table); ++i) {
    GDALColorEntry colour{};
    GDALGetColorEntryAsRGB(table, i, &colour);
    for (const short channel : {colour.c1, colour.c2, colour.c3})
      palette.push_back(static_cast<std::uint8_t>(channel));
  }
  return palette;
}

/// Colours by what the bands are said to be; three bands of which nothing is said are red, green and blue.
ColourEncoding colours_of(GDALDatasetH dataset, SampleType type, std::optional<double> nodata) {
  ColourEncoding colours;
  colours.type = type;
  colours.bits = type == SampleType::uint8 ? 8 : 16;
  colours.nodata = nodata;
  GDALRasterBandH first = GDALGetRasterBand(dataset, 1);
  if (const char* bits = GDALGetMetadataItem(first, "NBITS", "IMAGE_STRUCTURE"))
    if (const int n = std::atoi(bits); n >= 1 && n < colours.bits) colours.bits = n;
  std::vector<int> found(3, -1);
  const int bands = GDALGetRasterCount(dataset);
  for (int b = bands; b >= 1; --b) {
    const GDALColorInterp kind = GDALGetRasterColorInterpretation(GDALGetRasterBand(dataset, b));
    if (kind >= GCI_RedBand && kind <= GCI_BlueBand)
      found[static_cast<std::size_t>(kind - GCI_RedBand)] = b - 1;
  }
  const bool all = found[0] >= 0 && found[1] >= 0 && found[2] >= 0;
  colours.channels = all ? found : bands >= 3 ? std::vector{0, 1, 2} : std::vector{0};
  if (GDALGetRasterColorInterpretation(first) == GCI_PaletteIndex && colours.channels.size() == 1)
    colours.palette = palette_of(first);
  return colours;
}

/// A file that was cut shows at its last row, which GDAL does not look at before it is read.
Status check_last_row(GDALDatasetH dataset, const fs::path& path) {
  const int columns = GDALGetRasterXSize(dataset), last = GDALGetRasterYSize(dataset) - 1;
  std::vector<double> row(static_cast<std::size_t>(columns));
  if (GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Read, 0, last, columns, 1, row.data(), columns, 1,
                   GDT_Float64, 0, 0) == CE_None)
    return {};
  return bad_data(fmt::format("{}: row {}: expected posts, found: {}", path.string(), last, found()));
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  register_gdal(kCacheBytes);
  const Quiet quiet;
  auto opened = open_dataset(path);
  if (!opened) return opened.error();
  const int bands = GDALGetRasterCount(opened->dataset.get());
  if (auto there = check_band(path, bands, options.overrides); !there) return there.error();
  if (auto mask = check_mask(opened->dataset.get(), path); !mask) return mask.error();
  GDALRasterBandH band = GDALGetRasterBand(opened->dataset.get(), options.overrides.band.value_or(1));
  const auto type = sample_type(band);
  if (!type)
    return bad_data(fmt::format("{}: expected real samples of at most 64 bits, found {}", path.string(),
                                GDALGetDataTypeName(GDALGetRasterDataType(band))));
  HeightTags tags = height_tags_of(opened->dataset.get(), band);
  apply_overrides(options.overrides, tags);
  auto encoding = height_encoding_of(path, *type, tags);
  RasterInfo info;
  info.path = path;
  info.format = std::string("gdal ") + GDALGetDriverShortName(GDALGetDatasetDriver(opened->dataset.get()));
  info.columns = GDALGetRasterXSize(opened->dataset.get());
  info.rows = GDALGetRasterYSize(opened->dataset.get());
  info.bands = bands;
  info.type = *type;
  info.whole_metres = encoding && encoding->whole_metres();
  info.georeference = opened->georeference;
  info.nodata = tags.nodata;
  info.unit = tags.unit;
  info.vertical = vertical_reference_of(opened->dataset.get());
  info.overrides = options.overrides;
  ColourEncoding colours = colours_of(opened->dataset.get(), info.type, info.nodata);
  colours.range = said_range(info.overrides, colours.bits);
  if (auto placed = place_raster(info); !placed) return placed.error();
  if (auto last = check_last_row(opened->dataset.get(), path); !last) return last.error();
  std::unique_ptr<RasterSource> source = std::make_unique<GdalSource>(
      std::move(info), std::move(*opened), std::move(encoding), std::move(colours));
  return source;
}

}  // namespace

}  // namespace cairn

/// The module's one entry: cairn::OpenThroughGdal.
extern "C" __attribute__((visibility("default"))) void cairn_open_through_gdal(
    const std::filesystem::path& path, const cairn::OpenOptions& options,
    cairn::Result<std::unique_ptr<cairn::RasterSource>>& out) {
  try {
    out = cairn::open(path, options);
  } catch (const std::exception& e) {
    out = cairn::bad_data(path.string() + ": expected a raster, found: " + e.what());
  }
}
