#include "runtime/gl/patch_records.h"

#include <cmath>
#include <cstddef>
#include <unordered_map>

#include "format/tile_edges.h"

namespace cairn::gl {
namespace {

static_assert(sizeof(PatchRecord) == 144 && offsetof(PatchRecord, across) == 80 &&
              offsetof(PatchRecord, height_origin) == 48);
static_assert(sizeof(PerimeterVertex) == 8);

/// Where the south-west corner of an area lies in a tile that covers it, 0…1, and the area's share of a side.
struct Window {
  double x = 0;
  double y = 0;
  double scale = 1;
};
Window window_in(const TileId& tile, const TileId& area) {
  const LatticePoint a = south_west_of(area), t = south_west_of(tile);
  const auto width = static_cast<double>(lattice_width(tile.level));
  return {static_cast<double>(a.x - t.x) / width, static_cast<double>(a.y - t.y) / width,
          std::ldexp(1.0, tile.level - area.level)};
}

void show_heights(const ShownTile& shown, const GridPatch& grid, ResidentTiles& resident,
                  PatchRecord& record) {
  const ResidentHeights* heights = resident.heights_of(shown.tile);
  if (!heights) return;
  const ShownSurface surface = ShownSurface::of(&heights->surface, shown.detail);
  record.dropped = static_cast<float>(heights->surface.id.level - surface.detail);
  const Window window = window_in(shown.tile.heights_id, grid.area);
  const double cells = resident.tile_size() - 1;
  record.height_layer = static_cast<std::int32_t>(resident.height_layer(*heights));
  record.height_base = heights->base;
  record.height_shift = heights->shift;
  record.height_step = static_cast<float>(window.scale * cells / grid.cells());
  record.height_origin = glm::vec2(window.x * cells, window.y * cells);
}

void show_imagery(const RenderTile& tile, const GridPatch& grid, ResidentTiles& resident,
                  PatchRecord& record) {
  if (!tile.visible) return;  // there for its walls: not worth an upload
  const auto place = resident.imagery_of(tile);
  if (!place) return;
  const Window window = window_in(tile.imagery_id, grid.area);
  record.imagery_layer = static_cast<std::int32_t>(place->layer);
  record.imagery_origin = glm::vec2(window.x, window.y);
  record.imagery_scale = static_cast<float>(window.scale);
  const WorldExtent extent = world_extent(tile.imagery_id, resident.tile_size());
  record.imagery_array_and_extent = static_cast<std::uint32_t>(place->array + 1) |
                                    static_cast<std::uint32_t>(extent.east) << 8 |
                                    static_cast<std::uint32_t>(extent.north) << 20;
}

constexpr float kFiner = -1;
/// The layers of the normal maps that a frame shows, by source; kFiner for what only finer ones show.
using ShownLayers = std::unordered_map<TileId, float>;

ShownLayers layers_of(std::span<const ShownTile* const> tiles, ResidentTiles& resident) {
  ShownLayers layers;
  for (const ShownTile* shown : tiles) {
    const ResidentHeights* heights = resident.heights_of(shown->tile);
    if (!heights) continue;
    TileId id = heights->surface.id;
    layers[id] = static_cast<float>(resident.height_layer(*heights));
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
      const Window window = window_in(id, beside);
      return {window.x - dx * window.scale, window.y - dy * window.scale, window.scale, found->second};
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

std::vector<PatchRecord> patch_records(const MeshPlan& plan, std::span<const ShownTile* const> tiles,
                                       ResidentTiles& resident, ColumnBuffer& columns, RowBuffer& rows) {
  const ShownLayers layers = layers_of(tiles, resident);
  std::unordered_map<TileId, std::array<glm::vec4, 4>> neighbours;  // of sources
  std::vector<PatchRecord> records;
  records.reserve(plan.patches.size());
  for (const GridPatch& grid : plan.patches) {
    PatchRecord record;
    record.column_table = columns.first_entry(grid.area.level, grid.area.x);
    record.row_table = rows.first_entry(grid.area.level, grid.area.y);
    record.cells_log2 = static_cast<std::uint32_t>(grid.cells_log2);
    record.cells_east = static_cast<std::uint32_t>(grid.cells_east);
    record.cells_north = static_cast<std::uint32_t>(grid.cells_north);
    record.perimeter = static_cast<std::uint32_t>(grid.perimeter);
    record.listed_sides = grid.listed_sides;
    const RenderTile& tile = tiles[grid.from]->tile;
    record.level = tile.heights ? tile.heights_id.level : tile.area.level;
    show_heights(*tiles[grid.from], grid, resident, record);
    if (record.height_layer >= 0) {
      const TileId& source = tile.heights_id;
      const auto [known, fresh] = neighbours.try_emplace(source);
      if (fresh) known->second = all_across(source, layers);
      record.across = known->second;
    }
    show_imagery(tile, grid, resident, record);
    records.push_back(record);
  }
  return records;
}

}  // namespace cairn::gl
