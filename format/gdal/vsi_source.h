#pragma once

#include <memory>
#include <string>

#include "cairn/byte_source.h"
#include "cairn/status.h"

namespace cairn {

/// Opens a file of GDAL's own file systems, such as /vsicurl/https://… or /vsizip/….
Result<std::unique_ptr<const ByteSource>> open_vsi_source(const std::string& file);

}  // namespace cairn
