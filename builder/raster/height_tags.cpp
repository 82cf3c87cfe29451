#include "builder/raster/height_tags.h"

#include <cmath>

#include <fmt/format.h>

#include "builder/raster/crs.h"
#include "builder/raster/io/printable.h"

namespace cairn {

Status check_band(const std::filesystem::path& path, int bands, const SourceOverrides& overrides) {
  const int band = overrides.band.value_or(1);
  if (band >= 1 && band <= bands) return {};
  return bad_data(fmt::format("{}: expected band {}, found {} band{}", path.string(), band, bands,
                              bands == 1 ? "" : "s"));
}

VerticalReference vertical_reference(const VerticalCrs& crs) {
  if (crs.is_ellipsoidal) return {crs.name, VerticalDatum::ellipsoid};
  return vertical_reference_named(crs.name);
}

void apply_vertical_crs(const VerticalCrs& crs, HeightTags& tags) {
  if (!tags.unit.empty()) return;
  tags.metres = crs.metres;
  if (crs.metres == 0) tags.unit = "the vertical CRS " + crs.name + ", which counts downwards";
}

void apply_overrides(const SourceOverrides& overrides, HeightTags& tags) {
  if (overrides.nodata) tags.nodata = overrides.nodata;
  tags.scale = overrides.scale.value_or(tags.scale);
  tags.offset = overrides.offset.value_or(tags.offset);
  if (overrides.unit) {
    tags.unit = *overrides.unit;
    tags.metres = metres_of_unit(tags.unit);
  } else if (overrides.crs && overrides.crs->find_first_of("+[") != std::string::npos) {
    if (const auto vertical = find_vertical_crs(*overrides.crs)) apply_vertical_crs(*vertical, tags);
  }
}

Result<HeightEncoding> height_encoding_of(const std::filesystem::path& path, SampleType type,
                                          const HeightTags& tags) {
  if (tags.metres == 0)
    return bad_data(fmt::format("{}: heights: expected metres or feet above a datum, found {}", path.string(),
                                printable(tags.unit)));
  const HeightEncoding encoding{.type = type,
                                .nodata = tags.nodata,
                                .scale = tags.scale * tags.metres,
                                .offset = tags.offset * tags.metres};
  if (std::isfinite(encoding.scale) && encoding.scale != 0 && std::isfinite(encoding.offset)) return encoding;
  return bad_data(fmt::format("{}: heights: expected a scale other than zero and an offset, found {} and {}",
                              path.string(), encoding.scale, encoding.offset));
}

}  // namespace cairn
