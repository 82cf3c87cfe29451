#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "builder/export/pack_patches.h"
#include "builder/export/tile_ranges.h"
#include "builder/export/world_ticks.h"
#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// A tile of Cesium's geographic scheme (TMS, EPSG:4326): level L has 2^(L+1) columns and 2^L rows, counted
/// from 180°W, 90°S.
struct GeographicTile {
  int level = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;

  /// Level 31 at most, or edges are no whole ticks.
  TickRect rect() const {
    const std::int64_t side = (std::int64_t{45} << 32) >> level;
    return {x * side, y * side, (x + 1) * side, (y + 1) * side};
  }
};

/// What CesiumJS and cesium-native take for the error of a tile of this level, in metres: a sixty-fifth of an
/// equatorial heightmap tile's width divided by four (CesiumTerrainProvider, TerrainProvider
/// .getEstimatedLevelGeometricErrorForAHeightmap).
double assumed_error_m(int level, const Ellipsoid& ellipsoid);

/// Ticks between the samples of the lattice of this order in tiles of a level.
inline std::int64_t lattice_step(int level, int order) {
  return (std::int64_t{1} << 32) >> (level + order);
}

/// Places that are nearer than the lattice of this order may have one u and v.
inline constexpr int kRimOrder = 9;

/// Which tiles a quantized-mesh export has and how far each may be off. Immutable, so that any thread may
/// ask.
class QuantizedMeshPlan {
 public:
  struct Options {
    std::optional<GeoBounds> region;
    std::optional<int> finest;          ///< the finest level of the export
    std::optional<double> max_error_m;  ///< of tiles without finer ones
    bool shifted = false;               ///< a geoid's undulations are added
  };

  /// usage where no level can keep its bound.
  static Result<QuantizedMeshPlan> make(const PackReader& pack, const PackPatches& patches,
                                        std::optional<double> finest_error_m, const Options& options);

  int finest() const { return finest_; }

  /// Both roots are always there; below them a tile comes with its three siblings, where the pack has data
  /// for one of them.
  bool has(const GeographicTile& tile) const;

  /// The tiles below this one, a list a level, for as many levels as there are but `levels` at most.
  std::vector<std::vector<TileRange>> below(const GeographicTile& tile, int levels) const;

  /// How far a tile may be off the source posts.
  double bound_m(const GeographicTile& tile) const;

  /// The step that all heights of a level are multiples of, a power of two: tiles then agree on common edges
  /// whatever their ranges.
  double height_step_m(int level) const { return height_steps_[static_cast<std::size_t>(level)]; }

  int interval_bits() const { return interval_bits_; }  ///< 2^this intervals along a side of a pack's tile

  /// The order of the lattice that a pack's level is of: a tile of the export has 45·2^order intervals of it.
  int order_of(int pack_level, int level) const { return pack_level + interval_bits_ + 2 - level; }

  /// Square blocks of tiles of one level, each a task; coarse levels first.
  struct Unit {
    int level = 0;
    std::int64_t x = 0;  ///< of the first tile
    std::int64_t y = 0;
    int side = 1;
  };
  std::vector<Unit> units() const;
  std::vector<GeographicTile> tiles_of(const Unit& unit) const;

 private:
  QuantizedMeshPlan(const PackPatches& patches, int interval_bits)
      : patches_(&patches), interval_bits_(interval_bits) {}

  bool has_data(const TickRect& rect, int level) const;
  void add_units(const GeographicTile& tile, int level, int block, std::vector<Unit>& out) const;
  void choose_height_steps(const Options& options);

  const PackPatches* patches_;
  int interval_bits_;
  int finest_ = 0;
  std::optional<double> max_error_m_;
  std::vector<TickRect> regions_;  // empty: all
  std::vector<double> height_steps_;
};

}  // namespace cairn
