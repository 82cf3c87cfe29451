#pragma once

#include <vector>

#include "builder/raster_source.h"
#include "builder/texel_window.h"
#include "format/status.h"

namespace cairn {

/// One texel in linear light: R, G, B times alpha, and alpha, 0…65535.
using WideTexel = float __attribute__((vector_size(16)));

/// Part of a window of texels, resampled from one image.
struct ResampledImage {
  int column = 0;  ///< of the part in the window
  int row = 0;
  int columns = 0;
  int rows = 0;
  std::vector<WideTexel> texels;  ///< alpha is 0 where the texel's centre lies outside the image
  std::vector<float> rims;        ///< pixels from the texel's centre to the image's rim
};

/// Resamples an image in linear light onto texels: cubic where they are no larger than its pixels, averaged
/// as far as they are larger (PixelTaps). Voids carry no weight. `turn` degrees are added to the window's
/// longitudes. A texel's value is a function of its place alone, whichever window asks.
Result<ResampledImage> resample_image(const RasterSource& source, const TexelWindow& window, double turn);

}  // namespace cairn
