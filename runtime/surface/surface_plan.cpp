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

SurfaceMesher::Kept SurfaceMesher::make(const SurfacePatch& patch, const SideVertices& sides) {
  PatchMesh made = build_patch_mesh(patch, sides);
  Kept kept;
  kept.vertices = static_cast<std::uint32_t>(made.vertices.size());
  kept.indices = static_cast<std::uint32_t>(made.indices.size());
  kept.first_vertex = vertices_.take(kept.vertices);
  kept.first_index = indices_.take(kept.indices);
  mesh_.uploads.push_back(
      {kept.first_vertex, kept.first_index, std::move(made.vertices), std::move(made.indices)});
  return kept;
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
  mesh_.draws.reserve(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const SurfacePatch& patch = patches[i];
    const SideVertices& sides = plan.joints.sides[i];
    const auto [at, fresh] = kept_.try_emplace(key_of(patch, sides));
    if (fresh) at->second = make(patch, sides);
    Kept& kept = at->second;
    kept.used = frame_;
    mesh_.draws.push_back({patch.area, static_cast<std::uint32_t>(patch.from), patch.surface.coarser_share(),
                           kept.first_vertex, kept.first_index, kept.indices});
    mesh_.triangles += kept.indices / 3;
  }
  append_walls(plan.partition, plan.joints, mesh_.walls);
  mesh_.triangles += mesh_.walls.indices.size() / 3;
  if (frame_ % kKeptFrames == 0) drop_unused();
  mesh_.vertex_end = vertices_.end();
  mesh_.index_end = indices_.end();
  return std::exchange(mesh_, {});
}

}  // namespace cairn
