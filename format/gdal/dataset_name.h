#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cairn/pack_layout.h"

namespace cairn {

/// What a name that GDAL is given asks for: FILE, or CAIRN:"FILE":LAYER or CAIRN:"FILE":LAYER:LEVEL, the
/// quotes as one likes.
struct DatasetName {
  std::string file;
  std::optional<Layer> layer;  ///< heights or imagery
  std::optional<int> level;
};

inline constexpr std::string_view kNamePrefix = "CAIRN:";

/// nullopt where a name that starts with the prefix has no layer.
std::optional<DatasetName> parse_dataset_name(std::string_view name);

std::string subdataset_name(const std::string& file, Layer layer);

}  // namespace cairn
