#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "builder/export/export_format.h"
#include "builder/export/glb_writer.h"
#include "builder/export/local_plane.h"

namespace cairn {

/// A region of a pack as one mesh for programs whose ground is flat.
struct RegionMesh {
  /// Metres to the east and the north of the region's middle and above the datum. Ground that the pack does
  /// not have is left out.
  GlbMesh ground;
  int texture_side = 0;  ///< pixels; 0 without imagery
  LocalPlane plane;
  GeoBounds bounds;
  int level = 0;  ///< of the pack's tiles that it is made of
  VerticalDatum datum = VerticalDatum::unknown;
  double bound_m = 0;
  double max_error_m = 0;  ///< against the source posts, along the vertical
  bool has_voids = false;
};

/// The mesh of the options' region, of all that was baked without one, which keeps their error or twice what
/// the pack is off its posts. usage where the region is no plane, the pack is farther off or the memory does
/// not hold the region; failed where `progress` cancels it.
Result<RegionMesh> make_region_mesh(const PackReader& pack, const ExportOptions& options,
                                    const ProgressCallback& progress);

/// One line of JSON that says where on Earth the mesh is and what was measured of it.
std::string describe_region_mesh(const RegionMesh& mesh);

/// The report of an export that wrote the mesh in so many bytes.
ExportReport report_of(const RegionMesh& mesh, std::uint64_t bytes);

}  // namespace cairn
