#pragma once

#include <vector>

#include "builder/imagery/linear_image.h"
#include "builder/imagery/texel_window.h"
#include "builder/raster/raster_source.h"
#include "cairn/status.h"

namespace cairn {

/// Part of a window of texels, resampled from one image.
struct ResampledImage {
  int column = 0;  ///< of the part in the window
  int row = 0;
  LinearImage texels;       ///< empty where a texel's centre lies outside the image
  bool is_opaque = false;   ///< where true, no texel has less than all coverage
  std::vector<float> rims;  ///< pixels from a texel's centre to the image's rim, where they were asked for
};

/// Resamples an image in linear light onto texels: cubic where they are no larger than its pixels, averaged
/// as far as they are larger (PixelTaps). Voids carry no weight. `turn` degrees are added to the window's
/// longitudes. A texel's value is a function of its place alone, whichever window asks.
Result<ResampledImage> resample_image(const RasterSource& source, const TexelWindow& window, double turn,
                                      bool with_rims);

/// resample_image() of an image whose columns depend on the longitude alone and its rows on the latitude
/// alone: one axis after the other.
Result<ResampledImage> resample_separable(const RasterSource& source, const TexelWindow& window, double turn,
                                          bool with_rims);

/// resample_image() of an image whose columns or rows do not run along meridians and parallels, in any CRS: in
/// two dimensions, at positions that a ProjectionMesh of the projection gives.
Result<ResampledImage> resample_warped(const RasterSource& source, const TexelWindow& window, double turn,
                                       bool with_rims);

}  // namespace cairn
