#include "builder/raster/tiff/tiff_colours.h"

#include <fmt/format.h>
#include <tiffio.h>

#include "builder/raster/height_encoding.h"

namespace cairn {

std::optional<int> alpha_sample_of(const TiffLayout& layout) {
  const int colours = layout.bands - static_cast<int>(layout.extra_samples.size());
  if (colours < 1) return std::nullopt;
  for (std::size_t i = 0; i < layout.extra_samples.size(); ++i)
    if (layout.extra_samples[i] == EXTRASAMPLE_ASSOCALPHA ||
        layout.extra_samples[i] == EXTRASAMPLE_UNASSALPHA)
      return colours + static_cast<int>(i);
  return std::nullopt;
}

namespace {

/// Why a photometric interpretation is no colours that cairn knows; empty where it is.
std::string objection_to(const TiffLayout& layout) {
  if (layout.type != SampleType::uint8 && layout.type != SampleType::uint16)
    return fmt::format("unsigned samples of at most 16 bits, found {}", to_string(layout.type));
  switch (layout.photometric) {
    case PHOTOMETRIC_MINISWHITE:
    case PHOTOMETRIC_MINISBLACK:
      return {};
    case PHOTOMETRIC_RGB:
      return layout.bands >= 3 ? "" : fmt::format("three bands of RGB, found {}", layout.bands);
    case PHOTOMETRIC_PALETTE:
      return layout.palette.empty() ? "a palette of at most 256 colours, found none" : "";
    case PHOTOMETRIC_YCBCR:
      return layout.compression == COMPRESSION_JPEG
                 ? ""
                 : "RGB, grey or a palette, found YCbCr without JPEG compression";
    case PHOTOMETRIC_SEPARATED:
      return "RGB, grey or a palette, found CMYK";
    default:
      return fmt::format("RGB, grey or a palette, found photometric {}", layout.photometric);
  }
}

}  // namespace

Result<ColourEncoding> colours_of_tiff(const TiffLayout& layout, std::optional<double> nodata,
                                       const std::filesystem::path& path) {
  if (const std::string objection = objection_to(layout); !objection.empty())
    return bad_data(fmt::format("{}: image: expected {}", path.string(), objection));
  ColourEncoding e;
  e.type = layout.type;
  e.bits = layout.bits;
  e.nodata = nodata;
  e.palette = layout.palette;
  e.white_is_zero = layout.photometric == PHOTOMETRIC_MINISWHITE;
  e.alpha = alpha_sample_of(layout);
  if (e.alpha) {
    const std::size_t extra = layout.extra_samples.size() - static_cast<std::size_t>(layout.bands - *e.alpha);
    e.premultiplied = layout.extra_samples[extra] == EXTRASAMPLE_ASSOCALPHA;
  }
  const bool is_rgb = e.palette.empty() && layout.bands - (e.alpha ? 1 : 0) >= 3;
  e.channels = is_rgb ? std::vector{0, 1, 2} : std::vector{0};
  if (is_rgb && !layout.red_green_blue.empty()) e.channels = layout.red_green_blue;
  return e;
}

Status read_tiff_colours(const TiffImage& image, const ColourEncoding& encoding, const PostWindow& window,
                         std::span<std::uint8_t> rgba) {
  const TiffLayout& layout = image.layout();
  if (!layout.planar && is_plain_rgb(encoding)) {
    const auto pixel_bytes = static_cast<std::size_t>(layout.bands);
    return image.visit(window, 0, [&](const TiffImage::Run& run) {
      expand_rgb(encoding, run.samples, pixel_bytes, static_cast<std::size_t>(run.count),
                 &rgba[4 * static_cast<std::size_t>(run.row * window.columns + run.column)]);
    });
  }
  ColourAssembly assembly(encoding, rgba);
  const auto wanted = [&](int channel) {
    for (const int c : encoding.channels)
      if (c == channel) return true;
    return encoding.alpha == channel;
  };
  const auto together = static_cast<std::size_t>(layout.samples_together());
  for (int plane = 0; plane < (layout.planar ? layout.bands : 1); ++plane) {
    if (layout.planar && !wanted(plane)) continue;
    const Status visited = image.visit(window, plane, [&](const TiffImage::Run& run) {
      const auto first = static_cast<std::size_t>(run.row * window.columns + run.column);
      for (std::size_t s = 0; s < together; ++s) {
        const std::byte* samples = run.samples == nullptr ? nullptr : run.samples + s * size_of(layout.type);
        assembly.add(plane + static_cast<int>(s), first, static_cast<std::size_t>(run.count), samples,
                     together);
      }
    });
    if (!visited) return visited;
  }
  assembly.finish();
  return {};
}

}  // namespace cairn
