#pragma once

#include <filesystem>

#include "builder/objects/model_stream.h"
#include "cairn/status.h"

namespace cairn {

/// Reads a model's file in a process of its own, the program cairn-model, which has limits of memory and
/// time: a file that makes a library of formats crash is an error like any other. Errors begin with the
/// file's name.
Result<SourceMesh> read_model_file(const std::filesystem::path& file);

/// Reads an image likewise: the mesh has this image and no triangles.
Result<SourceMesh> read_image_file(const std::filesystem::path& file);

}  // namespace cairn
