#pragma once

#include <filesystem>
#include <string_view>

#include "builder/raster/height_tags.h"

namespace cairn {

/// What a side-car FILE.aux.xml (GDAL's Persistent Auxiliary Metadata, also written by ArcGIS) says of a
/// band.
struct PamSidecar {
  std::optional<double> nodata;
  std::optional<double> scale;
  std::optional<double> offset;
  std::optional<std::string> unit;
  /// Whether it says where the raster lies, which GDAL alone reads.
  bool places = false;
};

/// Takes the text apart; statistics, histograms and whatever else it holds count for nothing. `band` from 1.
PamSidecar parse_pam(std::string_view xml, int band);

/// The side-car beside the file; empty where there is none.
PamSidecar read_pam_beside(const std::filesystem::path& file, int band);

/// Puts what the side-car says in place of the file's own tags, as GDAL does.
void apply_pam(const PamSidecar& pam, HeightTags& tags);

}  // namespace cairn
