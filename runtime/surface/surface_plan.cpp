#include "runtime/surface/surface_plan.h"

#include <utility>

#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/rim_walls.h"

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

void SurfaceMesher::drop_unused() {
  std::erase_if(kept_, [&](const auto& item) {
    const Kept& kept = item.second;
    if (kept.used + kKeptFrames >= frame_) return false;
    vertices_.release(kept.first_vertex, kept.vertices);
    indices_.release(kept.first_index, kept.indices);
    return true;
  });
}

SurfaceMesh SurfaceMesher::frame(std::span<const SurfaceArea> areas, const SurfaceRules& rules) {
  ++frame_;
  mesh_ = {};
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
  append_walls(plan.partition, plan.joints, mesh_.walls);
  mesh_.triangles += mesh_.walls.indices.size() / 3;
  if (frame_ % kFramesPerDrop == 0) drop_unused();
  mesh_.vertex_end = vertices_.end();
  mesh_.index_end = indices_.end();
  return std::exchange(mesh_, {});
}

}  // namespace cairn
