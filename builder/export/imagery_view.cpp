#include "builder/export/imagery_view.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "builder/export/jpeg_encoder.h"
#include "format/imagery_sampler.h"

namespace cairn {

Result<ImageryView> draw_imagery(const PackReader& pack, const GeoBounds& bounds, int size) {
  const auto levels = pack.levels(Layer::imagery);
  const double pixel = bounds.height() / size;
  const int level =
      std::clamp(static_cast<int>(std::ceil(-std::log2(pixel * (pack.header().tile_size - 1)) - 1e-9)),
                 levels->coarsest, levels->finest);
  ImagerySampler texels(pack);
  ImageryView view;
  view.size = size;
  view.rgba.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * 4);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const LonLat place{bounds.west + bounds.width() * (c + 0.5) / size,
                         bounds.north - bounds.height() * (r + 0.5) / size};
      const auto colour = texels.colour_at(place, level);
      if (!colour) return colour.error();
      view.is_empty = view.is_empty && (*colour)[3] == 0;
      view.rgba.insert(view.rgba.end(), colour->begin(), colour->end());
    }
  }
  return view;
}

Result<std::vector<std::byte>> encode_jpeg(const ImageryView& view) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(view.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < view.rgba.size(); i += 4) {
    const unsigned alpha = view.rgba[i + 3];
    for (std::size_t k = 0; k < 3; ++k)
      rgb.push_back(static_cast<std::uint8_t>((view.rgba[i + k] * alpha + 255 * (255 - alpha) + 127) / 255));
  }
  JpegBytes out;
  JpegEncoder encoder;
  bool good = encoder.start(view.size, view.size, out);
  for (int r = 0; r < view.size && good; ++r)
    good = encoder.write(rgb.data() +
                         std::size_t{3} * static_cast<std::size_t>(r) * static_cast<std::size_t>(view.size));
  if (!good || !encoder.end()) return failed(std::string("JPEG: ") + encoder.complaint());
  const auto* bytes = reinterpret_cast<const std::byte*>(out.data);
  return std::vector<std::byte>(bytes, bytes + out.size);
}

}  // namespace cairn
