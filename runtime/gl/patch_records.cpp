#include "runtime/gl/patch_records.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <unordered_map>

#include "format/tile_edges.h"
#include "runtime/view/screen_scale.h"

namespace cairn::gl {
namespace {

static_assert(sizeof(PatchRecord) == 128 && offsetof(PatchRecord, across) == 64 &&
              offsetof(PatchRecord, height_origin) == 16 && offsetof(PatchRecord, imagery_origin) == 32);

void show_heights(const RenderTile& tile, const TileId& area, const ResidentTiles& resident,
                  PatchRecord& record) {
  const ResidentHeights* heights = resident.heights_of(tile);
  if (!heights) return;
  const SurfaceWindow window = window_in(tile.heights_id, area);
  record.height_layer = static_cast<std::int32_t>(heights->layer);
  record.height_base = heights->base;
  record.height_shift = heights->shift;
  record.height_origin = glm::vec2(window.origin);
  record.height_scale = static_cast<float>(window.scale);
}

void show_imagery(const RenderTile& tile, const TileId& area, ResidentTiles& resident, PatchRecord& record) {
  if (!tile.visible) return;  // there for its walls: not worth an upload
  const auto place = resident.imagery_of(tile);
  if (!place) return;
  const SurfaceWindow window = window_in(tile.imagery_id, area);
  record.imagery_layer = static_cast<std::int32_t>(place->layer);
  record.imagery_origin = glm::vec2(window.origin);
  record.imagery_scale = static_cast<float>(window.scale);
  const WorldExtent extent = world_extent(tile.imagery_id, resident.tile_size());
  record.imagery_array_and_extent = static_cast<std::uint32_t>(place->array + 1) |
                                    static_cast<std::uint32_t>(extent.east) << 8 |
                                    static_cast<std::uint32_t>(extent.north) << 20;
}

constexpr float kFiner = -1;
/// The layers of the normal maps that a frame shows, by source; kFiner for what only finer ones show.
using ShownLayers = std::unordered_map<TileId, float>;

ShownLayers layers_of(std::span<const RenderTile* const> tiles, const ResidentTiles& resident) {
  ShownLayers layers;
  for (const RenderTile* tile : tiles) {
    const ResidentHeights* heights = resident.heights_of(*tile);
    if (!heights) continue;
    TileId id = heights->id;
    layers[id] = static_cast<float>(heights->layer);
    while (id.level > kMinLevel) {
      id = parent_of(id);
      if (!layers.emplace(id, kFiner).second) break;
    }
  }
  return layers;
}

/// What lies across a side: the source of the same level, or the finest coarser one.
glm::vec4 across(const TileId& source, std::int32_t dx, std::int32_t dy, const ShownLayers& layers) {
  const TileId beside = neighbour_of(source, dx, dy);
  for (TileId id = beside; is_valid(id); id = parent_of(id)) {
    if (const auto found = layers.find(id); found != layers.end()) {
      // The source's corner, as if the neighbour lay beside it also where the world is joined.
      const SurfaceWindow window = window_in(id, beside);
      return {window.origin.x - dx * window.scale, window.origin.y - dy * window.scale, window.scale,
              found->second};
    }
    if (id.level == kMinLevel) break;
  }
  return glm::vec4(kFiner);
}

std::array<glm::vec4, 4> all_across(const TileId& source, const ShownLayers& layers) {
  return {across(source, 0, -1, layers), across(source, 0, 1, layers), across(source, -1, 0, layers),
          across(source, 1, 0, layers)};
}

}  // namespace

std::vector<PatchRecord> patch_records(std::span<const SurfaceDraw> draws,
                                       std::span<const RenderTile* const> tiles, ResidentTiles& resident) {
  const ShownLayers layers = layers_of(tiles, resident);
  std::unordered_map<TileId, std::array<glm::vec4, 4>> neighbours;  // of sources
  std::vector<PatchRecord> records;
  records.reserve(draws.size());
  for (const SurfaceDraw& draw : draws) {
    PatchRecord record;
    const RenderTile& tile = *tiles[draw.tile];
    record.level = tile.heights ? tile.heights_id.level : tile.area.level;
    record.coarser_share = draw.coarser_share;
    show_heights(tile, draw.area, resident, record);
    if (record.height_layer >= 0) {
      const TileId& source = tile.heights_id;
      const auto [known, fresh] = neighbours.try_emplace(source);
      if (fresh) known->second = all_across(source, layers);
      record.across = known->second;
    }
    show_imagery(tile, draw.area, resident, record);
    records.push_back(record);
  }
  return records;
}

std::vector<DrapedSegment> drape_on(std::span<const SurfaceDraw> draws,
                                    std::span<const RenderTile* const> tiles, const ViewState& view,
                                    DrapeIndex& index, std::vector<PatchRecord>& records) {
  constexpr double kLeast_px = 0.25;
  const double degree_px = pixels_per_radian(view) * view.ellipsoid.equator_degree_m();
  std::vector<DrapedSegment> all;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const RenderTile& tile = *tiles[draws[i].tile];
    if (!tile.visible) continue;
    const double patch_px =
        degree_px * tile_width_degrees(draws[i].area.level) / std::max(tile.distance_m, 1.0);
    const auto segments = index.in(draws[i].area, kLeast_px / patch_px);
    records[i].first_segment = static_cast<std::uint32_t>(all.size());
    records[i].segment_count = static_cast<std::uint32_t>(segments.size());
    all.insert(all.end(), segments.begin(), segments.end());
  }
  return all;
}

}  // namespace cairn::gl
