#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <glm/vec3.hpp>

#include "cairn/geodesy.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// A point of the ground that a ray meets.
struct GroundHit {
  Geodetic at;            ///< the height is in the pack's vertical datum
  glm::dvec3 point{};     ///< geocentric metres
  glm::dvec3 normal{};    ///< of the ground there, a unit vector that points up
  double distance_m = 0;  ///< along the ray
  int level = 0;          ///< of the tile whose ground it is
  double error_m = 0;     ///< how far a source's post may lie from that tile's ground
};

/// What stands between two points.
struct SightLine {
  bool is_clear = true;               ///< no ground of the pack reaches the line
  std::optional<GroundHit> obstacle;  ///< where the line first meets the ground, if it does
  /// The least height of the line above the ground, in metres, its ends included; negative where ground rises
  /// above it, infinite where the pack has no ground under it.
  double clearance_m = 0;
  /// How far the clearance over the posts of the sources may be from that, from the errors that the index
  /// holds of the tiles.
  double error_m = 0;

  /// Whether the ground's errors cannot change the answer.
  bool is_certain() const { return clearance_m > error_m || clearance_m < -error_m; }
};

/// Answers questions about the ground of a pack at full detail: bilinear between the samples of the finest
/// tile at each place, as PackSampler has it. Lines are straight in space, without refraction.
///
/// Heights are in the pack's vertical datum, which is laid out as if it were the ellipsoid, as everywhere in
/// the runtime. Voids and places without tiles have no ground: rays pass.
///
/// It reads tiles when it needs them, and keeps the last ones: a call may take as long as some reads. Errors
/// are those of reading a tile. Not thread-safe: one object per thread, any number on one reader.
class GroundQuery {
 public:
  /// Keeps up to `cached_tiles` decoded tiles, about 1.4 MiB each of 513 samples. REQUIRES: a pack,
  /// cached_tiles >= 1.
  explicit GroundQuery(std::shared_ptr<const PackReader> pack, std::size_t cached_tiles = 64);
  GroundQuery(GroundQuery&&) noexcept;
  GroundQuery& operator=(GroundQuery&&) noexcept;
  ~GroundQuery();

  /// Returns where a ray first meets the ground, within a micrometre along the ray; nullopt where it does
  /// not within `farthest_m`. A ray that begins under the ground meets it at its origin. The direction is in
  /// geocentric metres and of any length but 0. usage where an argument is not finite.
  Result<std::optional<GroundHit>> ray(const glm::dvec3& origin, const glm::dvec3& direction,
                                       double farthest_m = 1e7);

  /// Returns whether the straight line between two points is free of ground, and by how much. usage where an
  /// argument is not finite.
  Result<SightLine> line_of_sight(const Geodetic& from, const Geodetic& to);

  /// Returns the upward unit normal of the ground at a place, in geocentric axes; nullopt where there is
  /// none. On an edge between two cells it is that of the north-eastern one.
  Result<std::optional<glm::dvec3>> normal(LonLat place);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
