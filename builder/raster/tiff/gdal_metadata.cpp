#include "builder/raster/tiff/gdal_metadata.h"

#include <fmt/format.h>

namespace cairn {

std::optional<std::string> gdal_metadata_item(std::string_view xml, std::string_view role, int band) {
  const std::string wanted = fmt::format("role=\"{}\"", role), sample = fmt::format("sample=\"{}\"", band);
  for (std::size_t at = xml.find("<Item"); at != std::string_view::npos; at = xml.find("<Item", at + 1)) {
    const std::size_t open_end = xml.find('>', at), close = xml.find("</Item>", at);
    if (open_end == std::string_view::npos || close == std::string_view::npos || open_end > close) break;
    const std::string_view attributes = xml.substr(at, open_end - at);
    const bool of_band = attributes.find("sample=\"") == std::string_view::npos
                             ? band == 0
                             : attributes.find(sample) != std::string_view::npos;
    if (attributes.find(wanted) != std::string_view::npos && of_band)
      return std::string(xml.substr(open_end + 1, close - open_end - 1));
  }
  return std::nullopt;
}

}  // namespace cairn
