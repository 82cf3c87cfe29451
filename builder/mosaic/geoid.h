#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "builder/mosaic/lattice.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// The height of the geoid above the WGS84 ellipsoid, from a raster of undulations in metres that covers the
/// Earth (for instance NGA's EGM96 grid of 15'). Immutable, so any thread may ask.
class Geoid {
 public:
  /// Reads the whole raster: 4 bytes a post, 4 MB for 15'. bad_data where it does not go around the Earth or
  /// has voids.
  static Result<Geoid> open(const std::filesystem::path& path);

  /// Metres, bicubic (Catmull-Rom) between the posts.
  double undulation(LonLat place) const;

 private:
  Geoid() = default;
  float post(std::int64_t i, std::int64_t j) const;

  LatticePlacement placement_;
  std::int64_t columns_ = 0;
  std::int64_t rows_ = 0;
  std::vector<float> posts_;  // south to north
};

}  // namespace cairn
