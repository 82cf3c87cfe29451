#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "builder/objects/model_stream.h"
#include "cairn/status.h"

namespace cairn {

/// Decodes a PNG, JPEG, TGA, BMP, GIF or PSD. Errors begin with `name`.
Result<SourceMesh::Image> decode_image(std::span<const std::byte> bytes, const std::string& name);
Result<SourceMesh::Image> decode_image_file(const std::filesystem::path& file);

}  // namespace cairn
