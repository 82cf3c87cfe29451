#pragma once

#include <span>

#include "runtime/gl/axis_buffer.h"
#include "runtime/gl/grid_indices.h"
#include "runtime/gl/patch_records.h"
#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {

/// The buffers of a frame's patches, and the calls that draw them: one a size of grid, instanced.
class GridBatch {
 public:
  GridBatch();

  /// With the program, the tables and the textures bound that terrain.vert and .frag read. Returns the
  /// triangles. `calls` false: all but the draw calls.
  std::size_t draw(std::span<const PatchRecord> records, std::span<const PerimeterVertex> perimeter,
                   const ColumnBuffer& columns, const RowBuffer& rows, bool calls);

 private:
  Buffer patches_ = make_buffer();
  Buffer perimeter_ = make_buffer();
  Buffer instances_ = make_buffer();
  VertexArray vertex_array_ = make_vertex_array();
  GridIndices indices_;
};

}  // namespace cairn::gl
