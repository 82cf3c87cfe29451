#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn {

/// The TIFF tag that GDAL writes XML to.
inline constexpr std::uint32_t kGdalMetadataTag = 42112;

/// An item of that XML, by its role, of a band (from 0; items of no
/// band are the first one's).
std::optional<std::string> gdal_metadata_item(std::string_view xml, std::string_view role, int band);

}  // namespace cairn
