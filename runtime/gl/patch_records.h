#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "runtime/gl/axis_buffer.h"
#include "runtime/gl/resident_tiles.h"
#include "runtime/surface/lod_transition.h"
#include "runtime/surface/mesh_plan.h"

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
  /// 8 bits: the array, 0 for none; 12 bits each: the source's texels inside the world, east and north.
  std::uint32_t imagery_array_and_extent = 0;
  glm::vec2 height_origin{0};
  glm::vec2 imagery_origin{0};
  std::int32_t imagery_layer = 0;
  float imagery_scale = 1;
  std::int32_t level = 0;
  float dropped = 0;  // of ShownSurface: how many levels less are shown than the source has
  /// Of the normal maps across the source's sides (south, north, west, east): where the source's south-west
  /// corner lies in it, 0…1, the source's share of its side, and its layer; a layer < 0 where there is none
  /// as coarse as the source or coarser.
  std::array<glm::vec4, 4> across{glm::vec4(-1), glm::vec4(-1), glm::vec4(-1), glm::vec4(-1)};
};

/// A record for each patch of a plan; `tiles` are those that its areas were made of.
std::vector<PatchRecord> patch_records(const MeshPlan& plan, std::span<const ShownTile* const> tiles,
                                       ResidentTiles& resident, ColumnBuffer& columns, RowBuffer& rows);

}  // namespace cairn::gl
