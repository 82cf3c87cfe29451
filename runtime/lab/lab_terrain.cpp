#include "runtime/lab/lab_terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "format/tile_edges.h"
#include "runtime/paging/tile_selection.h"
#include "runtime/view/ground_height.h"

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

}  // namespace

LabTerrain::LabTerrain(std::shared_ptr<const PackReader> pack)
    : contents_(std::make_unique<TileAvailability>(std::move(pack))),
      occluder_(contents_->lowest_m(), contents_->pack().header().body.shape),
      tree_(*contents_, occluder_) {
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
  if (area.level == kMaxLevel || !contents_->has(Layer::heights, area)) return false;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child) && contents_->has(Layer::heights, child)) return true;
  }
  return false;
}

void LabTerrain::list_finest(const TileId& area) {
  if (!has_finer(area)) {
    std::vector<TileId> parts;
    within_world(area, parts);
    for (const TileId& part : parts) {
      const IndexEntry source = *contents_->nearest(Layer::heights, part);
      finest_.push_back({part, source, volume_of(part, source)});
    }
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) list_finest(child);
  }
}

std::vector<LabTerrain::SceneArea> LabTerrain::areas_for(const ViewState& view, const SceneRules& rules) {
  SelectionView selection = selection_view(view, *contents_, occluder_, rules.pattern, eye_);
  if (!rules.with_ring) selection.ring = SplitSet();
  tree_.trim();
  const SelectionRules limits{rules.refine_px, std::numeric_limits<double>::infinity()};
  std::vector<SceneArea> areas;
  for (const CutNode& node : select_tiles(tree_, {&selection, 1}, limits, {}).cut) {
    if (!node.heights) continue;
    std::vector<TileId> parts;
    within_world(node.area, parts);
    for (const TileId& part : parts) areas.push_back({part, *node.heights});
  }
  std::sort(areas.begin(), areas.end(),
            [](const SceneArea& a, const SceneArea& b) { return a.area < b.area; });
  return areas;
}

void LabTerrain::within_world(const TileId& area, std::vector<TileId>& out) const {
  if (!overhangs(area)) return out.push_back(area);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) within_world(child, out);
  }
}

const BoundingVolume& LabTerrain::volume_of(const TileId& area, const IndexEntry& source) const {
  const auto [it, fresh] = volumes_.try_emplace({area, source.id});
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

/// How far the pack's finest heights may lie from what the source shows in an area.
double LabTerrain::error_m_of(const TileId& area, const IndexEntry& source) const {
  const bool is_finest = !has_finer(area) && contents_->nearest(Layer::heights, area) == source;
  return is_finest ? 0 : static_cast<double>(source.geometric_error_m);
}

Result<LodTile> LabTerrain::load(const TileId& area, const IndexEntry& source) {
  const double quantum_m = pack().header().quantum_m;
  LodTile tile{area,
               source.id,
               nullptr,
               source.min_quanta * quantum_m,
               source.max_quanta * quantum_m,
               error_m_of(area, source),
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
  const PackHeader& header = pack().header();
  LodScene scene{header.tile_size, header.quantum_m, lowest_m(), {}, header.body.shape};
  for (const auto& [area, source] : areas_for(view, rules)) {
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
  const auto entry = contents_->nearest(Layer::heights, tile_at(place, range->finest));
  if (!entry) return std::optional<double>();
  const auto tile = heights(*entry);
  if (!tile) return tile.error();
  return ground_height_m(**tile, entry->id, pack().header().quantum_m, place);
}

}  // namespace cairn
