#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "cairn/surface_mesh.h"
#include "cairn/view_state.h"
#include "runtime/gl/resident_tiles.h"
#include "runtime/surface/drape_index.h"

namespace cairn::gl {

/// What terrain.vert reads of a patch, as it declares it.
struct PatchRecord {
  std::int32_t height_layer = -1;
  std::int32_t height_base = 0;
  std::int32_t height_shift = 0;
  /// 8 bits: the array, 0 for none; 12 bits each: the source's texels inside the world, east and north.
  std::uint32_t imagery_array_and_extent = 0;
  glm::vec2 height_origin{0};
  float height_scale = 1;
  float coarser_share = 0;  // of SurfaceDraw
  glm::vec2 imagery_origin{0};
  std::int32_t imagery_layer = 0;
  float imagery_scale = 1;
  std::int32_t level = 0;
  std::uint32_t first_segment = 0;  // of those that are draped on it
  std::uint32_t segment_count = 0;
  std::int32_t unused = 0;  // the next starts at a multiple of sixteen bytes
  /// Of the normal maps across the source's sides (south, north, west, east): where the source's south-west
  /// corner lies in it, 0…1, the source's share of its side, and its layer; a layer < 0 where there is none
  /// as coarse as the source or coarser.
  std::array<glm::vec4, 4> across{glm::vec4(-1), glm::vec4(-1), glm::vec4(-1), glm::vec4(-1)};
};

/// A record for each patch; `tiles` are those that their numbers are of.
std::vector<PatchRecord> patch_records(std::span<const SurfaceDraw> draws,
                                       std::span<const RenderTile* const> tiles, ResidentTiles& resident);

/// The pieces of lines that are draped on the patches; writes into the records which are whose.
std::vector<DrapedSegment> drape_on(std::span<const SurfaceDraw> draws,
                                    std::span<const RenderTile* const> tiles, const ViewState& view,
                                    DrapeIndex& index, std::vector<PatchRecord>& records);

}  // namespace cairn::gl
