#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/raster/georeference.h"
#include "builder/raster/height_tags.h"
#include "builder/raster/tiff/tiff_handle.h"
#include "builder/raster/vertical_reference.h"
#include "cairn/status.h"

namespace cairn {

/// What GeoTIFF 1.1 (OGC 19-008r4) and GDAL add to a TIFF, as it stands in the tags.
struct GeoTiffTags {
  std::vector<double> pixel_scale;        ///< 33550
  std::vector<double> tiepoints;          ///< 33922: i, j, k, x, y, z each
  std::vector<double> transformation;     ///< 34264: 4×4, row-major
  std::map<int, int> short_keys;          ///< 34735, the keys that are numbers: EPSG codes and choices
  std::map<int, double> double_keys;      ///< 34736
  std::map<int, std::string> ascii_keys;  ///< 34737
  std::string gdal_metadata;              ///< 42112, XML
  std::string gdal_nodata;                ///< 42113

  bool has_place() const { return !tiepoints.empty() || !transformation.empty(); }
  bool has_crs() const { return !short_keys.empty(); }
};

GeoTiffTags read_geotiff_tags(const TiffHandle& handle);

/// Splits a key directory into keys; entries that point outside their arrays are left out.
void parse_geo_keys(std::span<const std::uint16_t> directory, std::span<const double> doubles,
                    std::string_view ascii, GeoTiffTags& tags);

/// The CRS alone, onto `georeference`: by the keys, else geographic. A code of a CRS that cairn does not
/// compute itself is set for place_raster() to find; bad_data where there is no code (naming what there is).
Status read_crs(const GeoTiffTags& tags, const std::filesystem::path& path, Georeference& georeference);

/// The posts' places. Pixel-is-area and pixel-is-point are told apart: x0, y0 are the first post's own.
/// bad_data as read_crs() says, or where numbers are missing.
Result<Georeference> georeference_of(const GeoTiffTags& tags, const std::filesystem::path& path);

/// What the tags say of a band's heights: GDAL's nodata, scale, offset and unit, else the vertical CRS's
/// unit. `band` from 1.
HeightTags height_tags_of(const GeoTiffTags& tags, int band);

/// What the keys say that heights are measured from: a vertical CRS, or a geographic one in three dimensions.
std::optional<VerticalReference> vertical_reference_of(const GeoTiffTags& tags);

/// Makes the tags those of a file in degrees on WGS84, for a CRS that the user names; what they say of
/// heights stays.
void drop_crs(GeoTiffTags& tags);

}  // namespace cairn
