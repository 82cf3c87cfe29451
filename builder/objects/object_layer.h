#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/bake/bake_session.h"
#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/object_options.h"
#include "cairn/progress.h"
#include "cairn/status.h"

namespace cairn {

/// The pack whose ground the objects stand on.
struct ObjectGround {
  Body body;
  int tile_size = 513;
  double quantum_m = 0.25;
  GeoBounds bounds;  ///< in which objects are scattered
};

/// What became of the objects.
struct ObjectSummary {
  std::uint64_t objects = 0;    ///< that are in the pack
  std::uint64_t left_out = 0;   ///< since there is no ground beneath them
  LonLat first_left_out;        ///< in the order of tiles
  std::uint64_t scattered = 0;  ///< of those in the pack
  std::uint64_t outside_limits =
      0;  ///< that were scattered where the ground is outside the limits of the rule
  struct Model {
    std::string name;
    std::uint64_t objects = 0;
    std::size_t triangles = 0;
    std::size_t vertices = 0;
    std::size_t levels = 0;
  };
  std::vector<Model> models;  ///< by number
};

/// Every file that decides the bytes of objects and models.
std::vector<std::filesystem::path> files_of(const ObjectOptions& options);

/// Adds the layers of objects and of models. The bytes do not depend on the order of the places.
///
/// The heights are read back from the session's writer, and each object is placed on the finest that covers
/// it. Places are sorted in a scratch file beside the target, so that memory does not grow with their number.
/// Works on all threads of the caller's arena. REQUIRES: all heights are in the session's writer.
Result<ObjectSummary> bake_objects(const ObjectOptions& options, const ObjectGround& ground, int threads,
                                   BakeSession& session, const ProgressCallback& progress);

}  // namespace cairn
