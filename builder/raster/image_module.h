#pragma once

#include "builder/raster/scanline_source.h"

namespace cairn {

/// What a module with a library of image formats offers: decoders for open_scanline_raster().
struct ImageModule {
  Result<ScanlineHeader> (*read_header)(const std::filesystem::path& path) = nullptr;
  DecodeRows decode = nullptr;
};

}  // namespace cairn
