#include "runtime/surface/surface_plan.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/patch_neighbours.h"
#include "runtime/surface/rim_walls.h"
#include "runtime/view/screen_scale.h"

namespace cairn {

SurfacePlan plan_surface(std::span<const SurfaceArea> areas, const SurfaceRules& rules) {
  SurfacePlan plan{partition_areas(areas, rules), {}};
  plan.joints = join_sides(plan.partition);
  return plan;
}

std::size_t SurfaceMesher::KeyHash::operator()(const Key& key) const noexcept {
  std::uint64_t hash = std::hash<TileId>{}(key.area);
  const auto mix = [&](std::uint64_t value) {
    hash = (hash ^ value) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 32;
  };
  mix(static_cast<std::uint64_t>(key.step) << 32 ^ static_cast<std::uint64_t>(key.finer_level));
  for (const std::uint64_t side : key.sides) mix(side);
  return static_cast<std::size_t>(hash);
}

SurfaceMesher::Key SurfaceMesher::key_of(const SurfacePatch& patch, const SideVertices& sides) {
  const SurfaceTile* tile = patch.surface.tile;
  return {patch.area,
          tile ? tile->id.level : kMinLevel - 1,
          tile ? patch.surface.finer_level() : 0,
          tile && patch.surface.coarser_share() > 0,
          static_cast<std::int16_t>(patch.cells_log2),
          static_cast<std::int16_t>(tile ? patch.step : 0),
          static_cast<std::int16_t>(patch.forced_log2),
          sides};
}

/// Makes the triangles of the patches with these numbers and places them in the buffers.
void SurfaceMesher::make(const SurfacePlan& plan, std::span<const std::pair<std::size_t, Kept*>> fresh) {
  std::vector<PatchMesh> made(fresh.size());
  workers_->run(fresh.size(), [&](std::size_t i) {
    const std::size_t patch = fresh[i].first;
    made[i] = build_patch_mesh(plan.partition.patches[patch], plan.joints.sides[patch]);
  });
  mesh_.uploads.reserve(fresh.size());
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    Kept& kept = *fresh[i].second;
    kept.vertices = static_cast<std::uint32_t>(made[i].vertices.size());
    kept.indices = static_cast<std::uint32_t>(made[i].indices.size());
    kept.first_vertex = vertices_.take(kept.vertices);
    kept.first_index = indices_.take(kept.indices);
    mesh_.uploads.push_back(
        {kept.first_vertex, kept.first_index, std::move(made[i].vertices), std::move(made[i].indices)});
  }
}

namespace {

/// Tiles of objects by their ids.
class ObjectTiles {
 public:
  using Tile = std::shared_ptr<const LoadedObjects>;

  explicit ObjectTiles(std::span<const Tile> tiles) {
    for (const Tile& tile : tiles) {
      by_id_[tile->tile()].push_back(&tile);
      coarsest_ = std::min(coarsest_, tile->tile().level);
    }
  }

  /// Calls use(tile) for each tile that covers the area and is coarser or of its level.
  template <class Use>
  void for_each_above(TileId area, Use use) const {
    for (; area.level >= coarsest_; area = parent_of(area)) {
      if (const auto found = by_id_.find(area); found != by_id_.end()) {
        for (const Tile* tile : found->second) use(*tile);
      }
      if (area.level == kMinLevel) return;
    }
  }

 private:
  std::unordered_map<TileId, std::vector<const Tile*>> by_id_;
  int coarsest_ = kMaxLevel + 1;
};

}  // namespace

/// Finds the feet of the objects in each patch that has some, where that was not done for an earlier frame.
void SurfaceMesher::place_objects(const ObjectScene& scene, const SurfaceRules& rules,
                                  const SurfacePlan& plan, std::span<Kept* const> shown) {
  if (scene.tiles.empty()) return;
  struct Work {
    std::size_t patch;
    std::size_t kept;  // of Kept::feet
    bool is_fresh;
  };
  const double per_radian = pixels_per_radian(rules.view);
  const auto& patches = plan.partition.patches;
  std::vector<Work> work;
  const auto add = [&](std::size_t i, const std::shared_ptr<const LoadedObjects>& tile, bool is_whole) {
    const double largest_m = static_cast<double>(tile->largest_m());
    if (largest_m * per_radian < scene.smallest_px * patches[i].distance_m) return;
    std::vector<KeptFeet>& feet = shown[i]->feet;
    const auto known =
        std::find_if(feet.begin(), feet.end(), [&](const KeptFeet& k) { return k.objects == tile; });
    const auto at = static_cast<std::size_t>(known - feet.begin());
    const bool is_fresh = known == feet.end();
    if (is_fresh)
      feet.push_back({tile, is_whole ? tile->all() : tile->inside(patches[i].area), {}, frame_, {}});
    feet[at].used = frame_;
    if (!feet[at].standing.empty()) work.push_back({i, at, is_fresh});
  };
  const ObjectTiles by_id(scene.tiles);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    by_id.for_each_above(patches[i].area, [&](const auto& tile) { add(i, tile, false); });
  }
  const PatchIndex index(patches);
  for (const auto& tile : scene.tiles) {
    const std::optional<std::size_t> patch = index.covering(tile->tile());
    if (patch && patches[*patch].area != tile->tile()) add(*patch, tile, true);
  }
  workers_->run(work.size(), [&](std::size_t k) {
    const Work& item = work[k];
    if (!item.is_fresh) return;
    KeptFeet& kept = shown[item.patch]->feet[item.kept];
    kept.feet = object_feet(patches[item.patch], plan.joints.sides[item.patch], scene.quantum_m,
                            kept.objects->tile(), kept.standing);
    kept.cluster = cluster_of(kept.standing, kept.feet);
  });
  for (const Work& item : work) {
    const KeptFeet& kept = shown[item.patch]->feet[item.kept];
    object_patches_.push_back({kept.objects.get(), kept.standing, kept.feet,
                               patches[item.patch].surface.coarser_share(), kept.cluster});
  }
}

void SurfaceMesher::drop_unused() {
  for (auto& [key, kept] : kept_)
    std::erase_if(kept.feet, [&](const KeptFeet& feet) { return feet.used + kKeptFrames < frame_; });
  std::erase_if(kept_, [&](const auto& item) {
    const Kept& kept = item.second;
    if (kept.used + kKeptFrames >= frame_) return false;
    vertices_.release(kept.first_vertex, kept.vertices);
    indices_.release(kept.first_index, kept.indices);
    return true;
  });
}

SurfaceMesh SurfaceMesher::frame(std::span<const SurfaceArea> areas, const SurfaceRules& rules,
                                 const ObjectScene& objects) {
  ++frame_;
  mesh_ = {};
  object_patches_.clear();
  const SurfacePlan plan = plan_surface(areas, rules);
  const auto& patches = plan.partition.patches;
  std::vector<Kept*> shown;
  shown.reserve(patches.size());
  std::vector<std::pair<std::size_t, Kept*>> fresh;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto [at, is_fresh] = kept_.try_emplace(key_of(patches[i], plan.joints.sides[i]));
    if (is_fresh) fresh.emplace_back(i, &at->second);
    at->second.used = frame_;
    shown.push_back(&at->second);
  }
  make(plan, fresh);
  mesh_.draws.reserve(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const Kept& kept = *shown[i];
    mesh_.draws.push_back({patches[i].area, static_cast<std::uint32_t>(patches[i].from),
                           patches[i].surface.coarser_share(), kept.first_vertex, kept.first_index,
                           kept.indices});
    mesh_.triangles += kept.indices / 3;
  }
  place_objects(objects, rules, plan, shown);
  append_walls(plan.partition, plan.joints, mesh_.walls);
  mesh_.triangles += mesh_.walls.indices.size() / 3;
  if (frame_ % kFramesPerDrop == 0) drop_unused();
  mesh_.vertex_end = vertices_.end();
  mesh_.index_end = indices_.end();
  return std::exchange(mesh_, {});
}

}  // namespace cairn
