#pragma once

#include "builder/raster/colour_encoding.h"
#include "builder/raster/tiff/tiff_image.h"

namespace cairn {

/// How the pixels of a TIFF are colours: its photometric interpretation and extra samples. A fourth band is
/// alpha only where the file says so (NAIP's is near infrared). bad_data for CMYK, CIELab, uncompressed YCbCr
/// and samples other than unsigned integers of at most 16 bits.
Result<ColourEncoding> colours_of_tiff(const TiffLayout& layout, std::optional<double> nodata,
                                       const std::filesystem::path& path);

/// The sample that is a pixel's alpha, where the file says that one is.
std::optional<int> alpha_sample_of(const TiffLayout& layout);

/// Reads a window's colours.
Status read_tiff_colours(const TiffImage& image, const ColourEncoding& encoding, const PostWindow& window,
                         std::span<std::uint8_t> rgba);

}  // namespace cairn
