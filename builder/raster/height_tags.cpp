#include "builder/raster/height_tags.h"

#include <cmath>

#include <fmt/format.h>

#include "builder/raster/crs.h"
#include "builder/raster/io/printable.h"

namespace cairn {

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
