#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "builder/raster/crs_transform.h"
#include "builder/raster/height_encoding.h"
#include "builder/raster/vertical_reference.h"
#include "cairn/source_rule.h"
#include "cairn/status.h"

namespace cairn {

/// What a file says of its heights besides their type.
struct HeightTags {
  std::optional<double> nodata;
  double scale = 1;   ///< height in the unit = sample · scale + offset
  double offset = 0;  ///< in the unit
  /// As the file spells the unit; empty where it says none, which is the metre.
  std::string unit;
  /// Metres of the unit; 0 where it is no length upwards that cairn knows.
  double metres = 1;
};

/// bad_data where the user asks for a band that a file of so many has not.
Status check_band(const std::filesystem::path& path, int bands, const SourceOverrides& overrides);

/// The reference of a CRS's vertical part.
VerticalReference vertical_reference(const VerticalCrs& crs);

/// Puts the unit of a CRS's vertical part in, where the band has none of its own.
void apply_vertical_crs(const VerticalCrs& crs, HeightTags& tags);

/// Puts what the user says in place of the tags. The vertical part of a CRS says the unit where nothing else
/// does.
void apply_overrides(const SourceOverrides& overrides, HeightTags& tags);

/// The encoding that the tags make. bad_data where the unit is unknown, the scale zero or a number not
/// finite.
Result<HeightEncoding> height_encoding_of(const std::filesystem::path& path, SampleType type,
                                          const HeightTags& tags);

}  // namespace cairn
