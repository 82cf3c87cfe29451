#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cairn/status.h"
#include "runtime/lab/camera_path.h"
#include "runtime/lab/lab_terrain.h"
#include "runtime/lab/screen_error.h"
#include "runtime/lab/watertight.h"
#include "runtime/lod/lod_method.h"

namespace cairn {

/// A method with its options; quadtree takes part with several.
struct Contender {
  std::string label;
  const LodMethodInfo* method = nullptr;
  LodOptions options;
};

struct CompareSpec {
  std::vector<Contender> contenders;
  std::vector<double> tolerances_px;
  SceneRules tiles;  ///< refine_px as a share of the tolerance
  int width_px = 1920;
  int height_px = 1080;
  int threads = 2;  ///< of the measure; methods run on one
  bool with_bound =
      false;  ///< adds a record "greedy-tin" per frame and tolerance: about the fewest triangles
};

/// The figures of one method at one tolerance in one frame.
struct FrameRecord {
  std::string flight;
  std::string method;
  double tolerance_px = 0;
  std::size_t frame = 0;
  double pitch_deg = 0;

  std::uint64_t map_triangles = 0;  ///< with every sample of the whole map, visible or not
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t index_bytes = 0;    ///< 4 per list index of the final mesh
  std::uint64_t strip_indices = 0;  ///< of the method's own triangulation, in its shortest form
  std::uint64_t batches = 0;        ///< parts of that form
  double selection_ms = 0;          ///< CPU of one thread
  double building_ms = 0;
  double preparing_ms = 0;  ///< of tiles that are new in this frame

  ScreenError error;
  bool keeps_tolerance = false;  ///< error.max_px is within the tolerance, to the measure's own error
  bool joins = false;            ///< there is a frame before, so that error.max_pop_px is set

  std::uint64_t tiles = 0;           ///< whose data the scene shows
  std::uint64_t new_tiles = 0;       ///< of these, not in the frame before
  std::uint64_t useful_tiles = 0;    ///< visible, where their parents would be off by a quarter of a pixel
  std::uint64_t resident_bytes = 0;  ///< decoded tiles and what the method keeps beside them
  std::uint64_t loaded_bytes = 0;    ///< of the scene's blocks, as stored
  std::uint64_t useful_loaded_bytes = 0;
  std::optional<MeshFaults> faults;  ///< of the whole map's mesh; in the first frame, at the
                                     ///< largest tolerance
};

using TakeRecord = std::function<void(const FrameRecord&)>;

/// Flies the path with every contender at every tolerance, and passes on the records frame by frame. `full`,
/// which is large and has no tolerance, is drawn at the largest tolerance and in the first frame only.
Status compare(LabTerrain& terrain, const CameraPath& path, const CompareSpec& spec, const TakeRecord& take);

}  // namespace cairn
