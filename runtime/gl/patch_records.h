#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "runtime/gl/axis_buffer.h"
#include "runtime/gl/mesh_plan.h"
#include "runtime/gl/resident_tiles.h"
#include "runtime/gl/shown_tiles.h"

namespace cairn::gl {

/// What terrain.vert reads of a patch, as it declares it.
struct PatchRecord {
  std::uint32_t column_table = 0;
  std::uint32_t row_table = 0;
  std::uint32_t cells_log2 = 0;
  std::uint32_t cells_east = 0;
  std::uint32_t cells_north = 0;
  std::uint32_t perimeter = 0;
  std::uint32_t listed_sides = 0;
  std::int32_t height_layer = -1;
  std::int32_t height_base = 0;
  std::int32_t height_shift = 0;
  float height_step = 0;
  std::int32_t imagery_array = 0;
  glm::vec2 height_origin{0};
  glm::vec2 imagery_origin{0};
  std::int32_t imagery_layer = 0;
  float imagery_scale = 1;
  std::int32_t level = 0;
  float dropped = 0;  // of ShownSurface: how many levels less are shown than the source has
};

/// A record for each patch of a plan; `tiles` are those that its areas were made of.
std::vector<PatchRecord> patch_records(const MeshPlan& plan, std::span<const ShownTile* const> tiles,
                                       ResidentTiles& resident, ColumnBuffer& columns, RowBuffer& rows);

}  // namespace cairn::gl
