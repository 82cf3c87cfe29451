#include "builder/imagery/image_resample.h"

namespace cairn {

Result<ResampledImage> resample_image(const RasterSource& source, const TexelWindow& window, double turn,
                                      bool with_rims) {
  const Georeference& g = source.info().georeference;
  const bool has_meridian_columns =
      (g.crs == Georeference::Crs::geographic || g.crs == Georeference::Crs::web_mercator) &&
      g.is_straight() && g.dx > 0;
  if (!has_meridian_columns) return resample_warped(source, window, turn, with_rims);
  return resample_separable(source, window, turn, with_rims);
}

}  // namespace cairn
