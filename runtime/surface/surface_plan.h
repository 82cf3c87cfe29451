#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cairn/loaded_objects.h"
#include "cairn/surface_mesh.h"
#include "runtime/surface/frame_workers.h"
#include "runtime/surface/object_feet.h"
#include "runtime/surface/patch_partition.h"
#include "runtime/surface/range_arena.h"
#include "runtime/surface/side_joints.h"

namespace cairn {

/// The patches of a surface and how they meet, without their triangles.
struct SurfacePlan {
  PatchPartition partition;
  SideJoints joints;
};

/// Chooses the patches of a view and joins them. REQUIRES: no two areas overlap.
SurfacePlan plan_surface(std::span<const SurfaceArea> areas, const SurfaceRules& rules);

/// Which objects stand on a surface, and how large they must be to be drawn.
struct ObjectScene {
  std::span<const std::shared_ptr<const LoadedObjects>> tiles;
  double quantum_m = 0;
  double smallest_px = 1;
};

/// Objects of one tile in one patch of a frame, and where they stand.
struct ObjectPatch {
  const LoadedObjects* objects = nullptr;
  std::span<const StandingObject> standing;
  std::span<const ObjectFoot> feet;
  float coarser_share = 0;  ///< of the patch, see SurfaceDraw
  ObjectCluster cluster;
};

/// Makes the meshes of frames, and keeps those of patches from frame to frame: a frame makes what is new.
///
/// What is drawn at a place is its area's surface and nobody else's. Patches that kKeptFrames frames have not
/// shown are dropped. One thread calls; `threads` more help it with triangles.
class SurfaceMesher {
 public:
  explicit SurfaceMesher(int threads) : workers_(std::make_unique<FrameWorkers>(threads)) {}

  /// REQUIRES: no two areas overlap; a tile of one id has one content for as long as this lives.
  SurfaceMesh frame(std::span<const SurfaceArea> areas, const SurfaceRules& rules,
                    const ObjectScene& objects = {});

  /// The last frame's objects that may be large enough to be drawn, patch by patch. Holds until the next
  /// frame.
  std::span<const ObjectPatch> object_patches() const { return object_patches_; }

 private:
  static constexpr std::uint64_t kKeptFrames = 8, kFramesPerDrop = 4;

  /// What a patch's triangles depend on.
  struct Key {
    TileId area;
    int source_level = 0;
    int finer_level = 0;
    bool glides = false;
    std::int16_t cells_log2 = 0;
    std::int16_t step = 0;
    std::int16_t forced_log2 = 0;
    SideVertices sides{};
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const noexcept;
  };
  /// Of the objects that one tile has in a patch.
  struct KeptFeet {
    std::shared_ptr<const LoadedObjects> objects;
    std::span<const StandingObject> standing;
    std::vector<ObjectFoot> feet;
    std::uint64_t used = 0;  // the last frame
    ObjectCluster cluster;
  };
  struct Kept {
    std::uint32_t first_vertex = 0;
    std::uint32_t vertices = 0;
    std::uint32_t first_index = 0;
    std::uint32_t indices = 0;
    std::uint64_t used = 0;  // the last frame
    std::vector<KeptFeet> feet;
  };

  static Key key_of(const SurfacePatch& patch, const SideVertices& sides);
  void make(const SurfacePlan& plan, std::span<const std::pair<std::size_t, Kept*>> fresh);
  void place_objects(const ObjectScene& scene, const SurfaceRules& rules, const SurfacePlan& plan,
                     std::span<Kept* const> shown);
  void drop_unused();

  std::unique_ptr<FrameWorkers> workers_;
  std::unordered_map<Key, Kept, KeyHash> kept_;
  RangeArena vertices_;
  RangeArena indices_;
  SurfaceMesh mesh_;
  std::vector<ObjectPatch> object_patches_;
  std::uint64_t frame_ = 0;
};

}  // namespace cairn
