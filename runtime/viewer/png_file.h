#pragma once

#include <filesystem>

#include "cairn/status.h"
#include "runtime/gl/picture.h"
#include "runtime/viewer/numbered_file.h"

namespace cairn::viewer {

/// Writes the picture as an 8-bit sRGB PNG. failed names the file.
Status write_png(const std::filesystem::path& path, const gl::Picture& picture);
Status write_png(const NumberedFile& file, const gl::Picture& picture);

}  // namespace cairn::viewer
