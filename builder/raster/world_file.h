#pragma once

#include <optional>
#include <string_view>

#include "builder/raster/raster_source.h"

namespace cairn {

/// The place of an image that does not say its own: by a world file beside it (IMAGE.pgw, .tfw, .jgw, .j2w,
/// .pngw …, .wld), whose CRS is that of a .prj beside it or else geographic; without a world file by
/// options.bounds, in degrees; else bad_data that says what was looked for.
Result<Georeference> georeference_beside(const std::filesystem::path& image, std::int64_t columns,
                                         std::int64_t rows, const OpenOptions& options);

/// The same where the image says its CRS and not its place.
Result<Georeference> place_beside(const std::filesystem::path& image, std::int64_t columns, std::int64_t rows,
                                  const OpenOptions& options, Georeference crs);

/// Sets the CRS that a WKT text defines (OGC's or ESRI's): one of cairn's by its EPSG code or its name, else
/// another, which place_raster() finds. Returns false where the text is no WKT.
bool set_crs_of_wkt(Georeference& georeference, std::string_view wkt);

/// The name that a WKT text gives its CRS, for messages.
std::string_view name_of_wkt(std::string_view wkt);

/// The vertical part of the CRS of the .prj beside the image, OGC's or ESRI's. nullopt where there is none.
std::optional<VerticalCrs> vertical_crs_beside(const std::filesystem::path& image);

/// The CRS of the .prj beside the image, where there is one, else geographic.
Status read_prj_beside(const std::filesystem::path& image, Georeference& georeference);

}  // namespace cairn
