#include "builder/imagery/image_resample.h"

namespace cairn {

Result<ResampledImage> resample_image(const RasterSource& source, const TexelWindow& window, double turn,
                                      bool with_rims) {
  if (source.info().georeference.crs == Georeference::Crs::utm)
    return resample_warped(source, window, turn, with_rims);
  return resample_separable(source, window, turn, with_rims);
}

}  // namespace cairn
