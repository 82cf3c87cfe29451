#include "builder/export/tiff_writer.h"

#include <cassert>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <tiffio.h>

#include "format/file.h"

namespace cairn {
namespace {

constexpr ttag_t kModelPixelScale = 33550;
constexpr ttag_t kModelTiepoint = 33922;
constexpr ttag_t kGeoKeyDirectory = 34735;
constexpr ttag_t kGeoDoubleParams = 34736;
constexpr ttag_t kGeoAsciiParams = 34737;
constexpr ttag_t kGdalNodata = 42113;
constexpr double kMostClassicBytes = 3.5e9;

/// Adds the tags that libtiff does not know by itself.
void declare_tags(TIFF* tiff) {
  static const TIFFFieldInfo fields[] = {
      {kModelPixelScale, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("ModelPixelScale")},
      {kModelTiepoint, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("ModelTiepoint")},
      {kGeoKeyDirectory, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_SHORT, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("GeoKeyDirectory")},
      {kGeoDoubleParams, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("GeoDoubleParams")},
      {kGeoAsciiParams, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_ASCII, FIELD_CUSTOM, 1, 0,
       const_cast<char*>("GeoAsciiParams")},
      {kGdalNodata, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_ASCII, FIELD_CUSTOM, 1, 0,
       const_cast<char*>("GDAL_NODATA")},
  };
  TIFFMergeFieldInfo(tiff, fields, static_cast<std::uint32_t>(std::size(fields)));
}

int keep_complaint(TIFF*, void* complaint, const char*, const char* format, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  *static_cast<std::string*>(complaint) = text;
  return 1;
}

std::size_t bytes_of(TiffWriter::Pixel pixel) {
  return pixel == TiffWriter::Pixel::int16 ? 2 : 4;
}

}  // namespace

struct TiffWriter::State {
  ~State() {
    if (tiff != nullptr) TIFFClose(tiff);
    std::error_code ignored;
    if (!finished && made) std::filesystem::remove(part, ignored);
  }

  bool start(const GeoGrid& geo, VerticalDatum datum) {
    const double bytes = static_cast<double>(geo.columns) * geo.rows * static_cast<double>(bytes_of(pixel));
    TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_complaint, &complaint);
    TIFFOpenOptionsSetWarningHandlerExtR(options, keep_complaint, &complaint);
    tiff = TIFFOpenExt(part.c_str(), bytes > kMostClassicBytes ? "wl8" : "wl", options);
    TIFFOpenOptionsFree(options);
    made = tiff != nullptr;
    if (!made) return false;
    declare_tags(tiff);
    return set_image_tags(geo) && (pixel == Pixel::rgba8 ? set_colour_tags() : set_height_tags()) &&
           set_geo_tags(geo, datum);
  }

  bool set_image_tags(const GeoGrid& geo) {
    return set(TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(geo.columns)) &&
           set(TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(geo.rows)) &&
           set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
           set(TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE) &&
           set(TIFFTAG_ROWSPERSTRIP, std::uint32_t{64});
  }

  bool set_height_tags() {
    const bool whole = pixel == Pixel::int16;
    return set(TIFFTAG_BITSPERSAMPLE, whole ? 16 : 32) &&
           set(TIFFTAG_SAMPLEFORMAT, whole ? SAMPLEFORMAT_INT : SAMPLEFORMAT_IEEEFP) &&
           set(TIFFTAG_SAMPLESPERPIXEL, 1) && set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK) &&
           set(TIFFTAG_PREDICTOR, whole ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT) &&
           TIFFSetField(tiff, kGdalNodata, "-32768") == 1;
  }

  bool set_colour_tags() {
    const std::uint16_t alpha[] = {EXTRASAMPLE_UNASSALPHA};
    return set(TIFFTAG_BITSPERSAMPLE, 8) && set(TIFFTAG_SAMPLESPERPIXEL, 4) &&
           set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB) && set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL) &&
           TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, alpha) == 1;
  }

  bool set_geo_tags(const GeoGrid& geo, VerticalDatum datum) {
    constexpr std::uint16_t kArea = 1, kPoint = 2;
    const double scale[] = {geo.column_degrees, geo.row_degrees, 0};
    const double tiepoint[] = {0, 0, 0, geo.west, geo.north, 0};
    std::vector<std::uint16_t> keys{1,    1, 1, 0,  // version 1.1.1, count of keys
                                    1024, 0, 1, 2,  // model: geographic
                                    1025, 0, 1, pixel == Pixel::rgba8 ? kArea : kPoint};
    const auto add = [&keys](std::initializer_list<std::uint16_t> more) { keys.insert(keys.end(), more); };
    if (geo.body.is_earth()) {
      add({2048, 0, 1, 4326,    // WGS 84
           2054, 0, 1, 9102});  // degrees
    } else if (!add_body_keys(geo.body, keys)) {
      return false;
    }
    if (datum == VerticalDatum::egm96) add({4096, 0, 1, 5773, 4099, 0, 1, 9001});  // EGM96 height, metres
    keys[3] = static_cast<std::uint16_t>(keys.size() / 4 - 1);
    return TIFFSetField(tiff, kModelPixelScale, 3, scale) == 1 &&
           TIFFSetField(tiff, kModelTiepoint, 6, tiepoint) == 1 &&
           TIFFSetField(tiff, kGeoKeyDirectory, static_cast<int>(keys.size()), keys.data()) == 1;
  }

  /// Degrees on an ellipsoid that is spelt out. Only the name says that latitudes are planetographic.
  bool add_body_keys(const Body& body, std::vector<std::uint16_t>& keys) {
    constexpr std::uint16_t kUserDefined = 32767;
    const std::string name = body.name + (body.shape.is_sphere() ? "|" : " / Ographic|");
    const double axes[] = {body.shape.semi_major_m, body.shape.semi_minor_m};
    keys.insert(keys.end(), {2048,
                             0,
                             1,
                             kUserDefined,
                             2049,
                             kGeoAsciiParams,
                             static_cast<std::uint16_t>(name.size()),
                             0,
                             2050,
                             0,
                             1,
                             kUserDefined,
                             2054,
                             0,
                             1,
                             9102,  // degrees
                             2056,
                             0,
                             1,
                             kUserDefined,
                             2057,
                             kGeoDoubleParams,
                             1,
                             0,
                             2058,
                             kGeoDoubleParams,
                             1,
                             1});
    return TIFFSetField(tiff, kGeoDoubleParams, 2, axes) == 1 &&
           TIFFSetField(tiff, kGeoAsciiParams, name.c_str()) == 1;
  }

  template <class T>
  bool set(ttag_t tag, T value) {
    return TIFFSetField(tiff, tag, value) == 1;
  }
  Error error() const { return failed(part.string() + ": write: " + complaint); }

  std::filesystem::path target;
  std::filesystem::path part;
  Pixel pixel = Pixel::int16;
  TIFF* tiff = nullptr;
  std::string complaint = "libtiff cannot start";
  std::size_t row_bytes = 0;
  int next_row = 0;
  int rows = 0;
  bool made = false;
  bool finished = false;
};

TiffWriter::TiffWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
TiffWriter::TiffWriter(TiffWriter&&) noexcept = default;
TiffWriter& TiffWriter::operator=(TiffWriter&&) noexcept = default;
TiffWriter::~TiffWriter() = default;

Result<TiffWriter> TiffWriter::create(const std::filesystem::path& target, const GeoGrid& grid, Pixel pixel,
                                      VerticalDatum datum) {
  auto state = std::make_unique<State>();
  state->target = target;
  state->part = target.string() + ".part";
  state->pixel = pixel;
  state->row_bytes = static_cast<std::size_t>(grid.columns) * bytes_of(pixel);
  state->rows = grid.rows;
  if (!state->start(grid, datum)) return state->error();
  return TiffWriter(std::move(state));
}

Status TiffWriter::write_row(std::span<std::byte> row) {
  assert(row.size() == state_->row_bytes && state_->next_row < state_->rows);
  const auto number = static_cast<std::uint32_t>(state_->next_row++);
  return TIFFWriteScanline(state_->tiff, row.data(), number, 0) == 1 ? Status() : state_->error();
}

Status TiffWriter::finish() {
  assert(state_->next_row == state_->rows);
  if (TIFFFlush(state_->tiff) != 1) return state_->error();
  TIFFClose(std::exchange(state_->tiff, nullptr));
  const Status renamed = rename_durably(state_->part, state_->target);
  state_->finished = renamed.ok();
  return renamed;
}

}  // namespace cairn
