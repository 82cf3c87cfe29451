#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "builder/raster/raster_source.h"

namespace cairn::test {

/// Opens the bytes as a file of that name through one reader of builder/raster/formats/ alone, and reads the
/// first and the last posts of what opens, as heights and as colours. `bounds` are where an image without a
/// place of its own lies.
void open_and_read(const char* format, const std::string& name, std::span<const std::byte> bytes,
                   const std::optional<GeoBounds>& bounds = std::nullopt);

}  // namespace cairn::test
