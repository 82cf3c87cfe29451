#include "runtime/lab/lab_terrain.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <glm/geometric.hpp>

#include "format/tile_edges.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/view/ground_height.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

/// Decoded tiles kept, in number; beyond, those that nobody uses are dropped.
constexpr std::size_t kKeptTiles = 1500;

bool overhangs(const TileId& id) {
  const WorldExtent extent = world_extent(id, 513);
  return extent.east < 512 || extent.north < 512;
}

template <class Kept>
void drop_unused(Kept& kept) {
  if (kept.size() < kKeptTiles) return;
  std::erase_if(kept, [](const auto& item) { return item.second.use_count() == 1; });
}

double radius_m(const BoundingVolume& volume) {
  return glm::length(volume.half_axes[0] + volume.half_axes[1] + volume.half_axes[2]);
}

}  // namespace

LabTerrain::LabTerrain(std::shared_ptr<const PackReader> pack)
    : contents_(std::move(pack)), occluder_(contents_.lowest_m()) {
  const auto range = this->pack().levels(Layer::heights);
  if (!range) return;
  std::set<TileId> roots;
  for (std::size_t i = 0; i < this->pack().entry_count(); ++i) {
    const IndexEntry entry = this->pack().entry(i);
    if (entry.layer == Layer::heights && entry.id.level == range->coarsest) roots.insert(entry.id);
  }
  for (const TileId& root : roots) list_finest(root);
}

bool LabTerrain::has_finer(const TileId& area) const {
  if (area.level == kMaxLevel || !contents_.has(Layer::heights, area)) return false;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child) && contents_.has(Layer::heights, child)) return true;
  }
  return false;
}

void LabTerrain::list_finest(const TileId& area) {
  if (!has_finer(area)) {
    std::vector<TileId> parts;
    within_world(area, parts);
    for (const TileId& part : parts) {
      const IndexEntry source = *contents_.nearest(Layer::heights, part);
      finest_.push_back({part, source, volume_of(part, source)});
    }
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) list_finest(child);
  }
}

void LabTerrain::add_to_cover(const TileId& area, bool has_source, std::vector<TileId>& cover) const {
  if (has_source) cover.push_back(area);
  if (has_source || !contents_.is_above_tiles(area)) return;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) add_to_cover(child, contents_.has(Layer::heights, child), cover);
  }
}

std::vector<TileId> LabTerrain::areas_for(const ViewState& view, RefinementPattern pattern) {
  const double above_ground_m = view.height_m - contents_.ceiling_m(view.eye);
  const double ideal = level_for_pixel_size(view, above_ground_m, pack().header().tile_size);
  const TileId eye_tile = eye_.update(view.eye, ideal, kMinLevel, contents_.levels().finest);
  const SceneMap map = build_scene_map(
      {eye_tile, kMinLevel, pattern}, [this](const TileId& id) { return contents_.has(Layer::heights, id); });
  std::vector<TileId> cover;
  for (const SceneTile& tile : map) add_to_cover(tile.area, tile.has_source(), cover);
  return cover;
}

void LabTerrain::refine(const TileId& area, const ViewState& view, double refine_px,
                        std::vector<TileId>& out) const {
  const IndexEntry source = *contents_.nearest(Layer::heights, area);
  const BoundingVolume& volume = volume_of(area, source);
  const bool splits = refine_px > 0 && has_finer(area) && ViewFrustum(view, occluder_).sees(volume) &&
                      Screen(view).bound_px(static_cast<double>(source.geometric_error_m), volume.centre,
                                            radius_m(volume)) > refine_px;
  if (!splits) return within_world(area, out);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) refine(child, view, refine_px, out);
  }
}

void LabTerrain::within_world(const TileId& area, std::vector<TileId>& out) const {
  if (!overhangs(area)) return out.push_back(area);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) within_world(child, out);
  }
}

const BoundingVolume& LabTerrain::volume_of(const TileId& area, const IndexEntry& source) const {
  const auto [it, fresh] = volumes_.try_emplace(area);
  if (fresh) {
    const double quantum_m = pack().header().quantum_m;
    it->second = bounding_volume(tile_bounds(area), source.min_quanta * quantum_m,
                                 source.max_quanta * quantum_m, occluder_);
  }
  return it->second;
}

Result<std::shared_ptr<const HeightTile>> LabTerrain::heights(const IndexEntry& entry) {
  drop_unused(heights_);
  if (const auto it = heights_.find(entry.id); it != heights_.end()) return it->second;
  Result<HeightTile> tile = pack().read_height_tile(entry);
  if (!tile) return tile.error();
  return heights_[entry.id] = std::make_shared<const HeightTile>(std::move(*tile));
}

Result<std::shared_ptr<const std::vector<std::byte>>> LabTerrain::flags(const TileId& id) {
  drop_unused(flags_);
  if (const auto it = flags_.find(id); it != flags_.end()) return it->second;
  std::shared_ptr<const std::vector<std::byte>> block;
  if (const auto entry = pack().find(Layer::rqt, id)) {
    Result<std::vector<std::byte>> bytes = pack().read_block(*entry);
    if (!bytes) return bytes.error();
    block = std::make_shared<const std::vector<std::byte>>(std::move(*bytes));
  }
  return flags_[id] = block;
}

Result<LodTile> LabTerrain::load(const TileId& area, const IndexEntry& source) {
  const double quantum_m = pack().header().quantum_m;
  LodTile tile{area,
               source.id,
               nullptr,
               source.min_quanta * quantum_m,
               source.max_quanta * quantum_m,
               has_finer(area) ? static_cast<double>(source.geometric_error_m) : 0,
               volume_of(area, source),
               nullptr};
  const auto samples = heights(source);
  if (!samples) return samples.error();
  tile.heights = *samples;
  const auto block = flags(source.id);
  if (!block) return block.error();
  tile.flags = *block;
  return tile;
}

Result<LodScene> LabTerrain::scene_for(const ViewState& view, const SceneRules& rules) {
  std::vector<TileId> areas;
  for (const TileId& area : areas_for(view, rules.pattern)) refine(area, view, rules.refine_px, areas);
  std::sort(areas.begin(), areas.end());
  LodScene scene{pack().header().tile_size, pack().header().quantum_m, lowest_m(), {}};
  for (const TileId& area : areas) {
    const IndexEntry source = *contents_.nearest(Layer::heights, area);
    if (area.level - source.id.level > std::ilogb(scene.tile_size - 1)) {
      return bad_data(pack().path().string() + ": " + to_string(area) +
                      ": expected a source with a sample at its corners, found " + to_string(source.id));
    }
    Result<LodTile> tile = load(area, source);
    if (!tile) return tile.error();
    scene.tiles.push_back(std::move(*tile));
  }
  return scene;
}

Result<std::optional<double>> LabTerrain::ground_m(LonLat place) {
  const auto range = pack().levels(Layer::heights);
  if (!range) return std::optional<double>();
  const auto entry = contents_.nearest(Layer::heights, tile_at(place, range->finest));
  if (!entry) return std::optional<double>();
  const auto tile = heights(*entry);
  if (!tile) return tile.error();
  return ground_height_m(**tile, entry->id, pack().header().quantum_m, place);
}

}  // namespace cairn
