#pragma once

// Level-of-detail methods: plain data in, a mesh out. One file a method in lod/, the folder is the list.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// What a command line may set. Parameters that follow from the tolerance are the methods' own.
struct LodOptions {
  bool roughness = false;           ///< quadtree: d2 of [4, (5.6)]
  bool angle_compensation = false;  ///< quadtree: C_N of [4, (5.9)]
};

/// One method at work on one flight. Results depend on nothing but the scene and the view, unless the method
/// says so. One thread only.
class LodMethod {
 public:
  virtual ~LodMethod() = default;

  /// What the method works out when tiles are loaded, once for each: keeps what the scene's tiles need and
  /// drops the rest. A runtime does it on its loading threads, so that its time is not a frame's.
  virtual void prepare(const LodScene& scene) = 0;
  /// Bytes that prepare() keeps beside the tiles.
  virtual std::uint64_t prepared_bytes() const = 0;

  /// REQUIRES: the scene was prepared.
  virtual LodMesh build(const LodScene& scene, const LodView& view) = 0;
};

struct LodMethodInfo {
  std::string_view name;
  bool keeps_tolerance;  ///< every finest sample in the picture is within the tolerance of its place, as long
                         ///< as the scene's own error allows; see Screen for the measure
  std::unique_ptr<LodMethod> (*create)(const LodOptions& options);
};

/// All methods, in the order of their files' names.
std::span<const LodMethodInfo* const> lod_methods();

/// The method of this name; null if there is none.
inline const LodMethodInfo* lod_method(std::string_view name) {
  for (const LodMethodInfo* method : lod_methods()) {
    if (method->name == name) return method;
  }
  return nullptr;
}

}  // namespace cairn
