// GeoTIFF 1.1 (OGC 19-008r4), written through libtiff with the three tags that a geographic raster needs.

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <iterator>
#include <memory>
#include <system_error>
#include <vector>

#include <tiffio.h>

#include "builder/export/height_image.h"
#include "builder/export/whole_metres.h"
#include "format/file.h"

namespace cairn {
namespace {

constexpr ttag_t kModelPixelScale = 33550;
constexpr ttag_t kModelTiepoint = 33922;
constexpr ttag_t kGeoKeyDirectory = 34735;
constexpr ttag_t kGdalNodata = 42113;

/// Adds the tags that libtiff does not know by itself.
void declare_tags(TIFF* tiff) {
  static const TIFFFieldInfo fields[] = {
      {kModelPixelScale, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("ModelPixelScale")},
      {kModelTiepoint, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("ModelTiepoint")},
      {kGeoKeyDirectory, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_SHORT, FIELD_CUSTOM, 1, 1,
       const_cast<char*>("GeoKeyDirectory")},
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

using TiffPointer = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

TiffPointer open_silently(const std::filesystem::path& path, std::string& complaint) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_complaint, &complaint);
  TIFFOpenOptionsSetWarningHandlerExtR(options, keep_complaint, &complaint);
  TIFF* tiff = TIFFOpenExt(path.c_str(), "wl", options);
  TIFFOpenOptionsFree(options);
  return {tiff, &TIFFClose};
}

bool set_image_tags(TIFF* tiff, const HeightImage& image, bool whole) {
  const auto size = static_cast<std::uint32_t>(image.size);
  return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, size) == 1 &&
         TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, size) == 1 &&
         TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, whole ? 16 : 32) == 1 &&
         TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, whole ? SAMPLEFORMAT_INT : SAMPLEFORMAT_IEEEFP) == 1 &&
         TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1) == 1 &&
         TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == 1 &&
         TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK) == 1 &&
         TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE) == 1 &&
         TIFFSetField(tiff, TIFFTAG_PREDICTOR, whole ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT) == 1 &&
         TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, std::uint32_t{64}) == 1;
}

bool set_geo_tags(TIFF* tiff, const HeightImage& image) {
  const double scale[] = {image.spacing, image.spacing, 0};
  const double tiepoint[] = {0, 0, 0, image.west, image.north, 0};
  std::vector<std::uint16_t> keys{1,    1, 1, 4,      // version 1.1.1, count of keys
                                  1024, 0, 1, 2,      // model: geographic
                                  1025, 0, 1, 2,      // raster: pixel is point
                                  2048, 0, 1, 4326,   // WGS 84
                                  2054, 0, 1, 9102};  // degrees
  if (image.datum == VerticalDatum::egm96) {
    keys.insert(keys.end(), {4096, 0, 1, 5773, 4099, 0, 1, 9001});  // EGM96 height, metres
    keys[3] = 6;
  }
  return TIFFSetField(tiff, kModelPixelScale, 3, scale) == 1 &&
         TIFFSetField(tiff, kModelTiepoint, 6, tiepoint) == 1 &&
         TIFFSetField(tiff, kGeoKeyDirectory, static_cast<int>(keys.size()), keys.data()) == 1 &&
         TIFFSetField(tiff, kGdalNodata, "-32768") == 1;
}

template <class T, class Convert>
bool write_rows(TIFF* tiff, const HeightImage& image, Convert convert) {
  const auto size = static_cast<std::size_t>(image.size);
  std::vector<T> row(size);
  for (std::size_t r = 0; r < size; ++r) {
    for (std::size_t c = 0; c < size; ++c) row[c] = convert(image.metres[r * size + c]);
    if (TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(r), 0) != 1) return false;
  }
  return TIFFFlush(tiff) == 1;
}

bool write_part(const std::filesystem::path& part, const HeightImage& image, std::string& complaint) {
  const TiffPointer tiff = open_silently(part, complaint);
  if (!tiff) return false;
  declare_tags(tiff.get());
  const bool whole = std::all_of(image.metres.begin(), image.metres.end(), [](double metres) {
    return std::isnan(metres) || whole_metres(metres) == metres;
  });
  if (!set_image_tags(tiff.get(), image, whole) || !set_geo_tags(tiff.get(), image)) return false;
  if (whole) return write_rows<std::int16_t>(tiff.get(), image, whole_metres);
  return write_rows<float>(tiff.get(), image, [](double metres) {
    return std::isnan(metres) ? static_cast<float>(kVoidMetres) : static_cast<float>(metres);
  });
}

}  // namespace

Status write_height_tiff(const std::filesystem::path& path, const HeightImage& image) {
  const std::filesystem::path part = path.string() + ".part";
  std::string complaint;
  Status status;
  if (!write_part(part, image, complaint)) status = failed(part.string() + ": write: " + complaint);
  if (status) status = rename_durably(part, path);
  std::error_code ignored;
  if (!status) std::filesystem::remove(part, ignored);
  return status;
}

}  // namespace cairn
