#pragma once

// Level-of-detail methods: plain data in, a mesh out. Each file of lod/ is a method; the folder is the list.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// The options of methods. What follows from the tolerance is no option.
struct LodOptions {
  bool roughness = false;           ///< quadtree: d2 of Melkisetoğlu 2005, eq. 5.6
  bool angle_compensation = false;  ///< quadtree: C_N of Melkisetoğlu 2005, eq. 5.9
  bool geomorph = false;            ///< block: heights change gradually (Melkisetoğlu 2005, §3.3 and §4.4)
};

/// A method, used for one flight by one thread. A mesh depends only on the scene and the view, unless the
/// method's file says otherwise.
class LodMethod {
 public:
  virtual ~LodMethod() = default;

  /// Works out what the method needs of each new tile of the scene, and drops it for tiles that are gone. A
  /// runtime does this on its loading threads, so its time is not part of a frame's.
  virtual void prepare(const LodScene& scene) = 0;
  /// Returns the bytes that prepare() keeps beside the tiles.
  virtual std::uint64_t prepared_bytes() const = 0;

  /// Returns the mesh for a view. REQUIRES: the scene was given to prepare().
  virtual LodMesh build(const LodScene& scene, const LodView& view) = 0;
};

struct LodMethodInfo {
  std::string_view name;
  bool keeps_tolerance;  ///< every visible finest sample is within the tolerance, by Screen's measure, as far
                         ///< as the scene's own error allows
  std::unique_ptr<LodMethod> (*create)(const LodOptions& options);
};

/// The LodMethodInfo::create of a method that has no options.
template <class Method>
std::unique_ptr<LodMethod> create_without_options(const LodOptions&) {
  return std::make_unique<Method>();
}

/// Returns all methods, in the order of their files' names.
std::span<const LodMethodInfo* const> lod_methods();

/// Returns the method of this name, null if there is none.
inline const LodMethodInfo* lod_method(std::string_view name) {
  for (const LodMethodInfo* method : lod_methods()) {
    if (method->name == name) return method;
  }
  return nullptr;
}

}  // namespace cairn
