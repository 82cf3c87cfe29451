#pragma once

#include <array>
#include <vector>

#include "builder/objects/model_stream.h"
#include "cairn/object_model.h"

namespace cairn {

/// Makes the vertices, indices and levels of detail of a model. Each level has about half the triangles of
/// the one before, and the largest distance that simplification has moved a surface by (meshoptimizer,
/// quadric error). A mesh with more vertices than a model may have is simplified until it has not. `texture`
/// are the vertices' places in the model's texture. The error is bad_data where nothing is left to draw.
Status make_geometry(const SourceMesh& mesh, const std::vector<std::array<float, 2>>& texture,
                     ObjectModel& model);

}  // namespace cairn
