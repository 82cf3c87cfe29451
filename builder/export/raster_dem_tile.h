#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "builder/export/mercator_tiles.h"
#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "builder/export/vertical_shift.h"
#include "cairn/pack_sampler.h"
#include "cairn/status.h"

namespace cairn {

/// How a MapLibre raster-dem source makes metres of a pixel: red·red_m + green·green_m + blue·blue_m -
/// base_m.
struct DemEncoding {
  const char* name = "terrarium";
  double red_m = 256;
  double green_m = 1;
  double blue_m = 1.0 / 256;
  double base_m = 32768;

  /// Terrarium (Tilezen 2017): steps of 1/256 m.
  static DemEncoding terrarium() { return {}; }
  /// Steps of the pack's quantum, in the middle of what 24 bits hold.
  static DemEncoding custom(double quantum_m);

  /// Of the nearest step, and the metres that it stands for.
  std::uint32_t pixel_of(double metres) const;
  double metres_of(std::uint32_t pixel) const;
};

inline constexpr int kDemTilePixels = 512;

/// The level, of those that a pack has, whose samples are the next finer than a zoom's pixels.
int dem_level(int tile_size, int zoom, int coarsest, int finest);

/// The first zoom whose pixels are no larger than the samples of the pack's finest level.
int finest_dem_zoom(int tile_size, int finest);

/// A tile of heights as its reader has them. Pixel i stands for the place (i + 1/2)/512 of the tile's width
/// from its west, and likewise from its north: so read MapLibre 6's DEMCoverage and its shaders.
struct RasterDemTile {
  std::vector<std::uint32_t> pixels;  ///< 512², rows from NORTH to south
  double max_error_m = 0;  ///< of MapLibre's bilinear reading at the pack's samples, their own error included
};

struct RasterDemSource {
  const PackPatches& patches;
  MetreTiles& tiles;
  const VerticalShift& shift;
  DemEncoding encoding;
  /// Whether there is a tile. MapLibre reads half a pixel beyond a tile from the one beside it, and repeats
  /// the last pixel where there is none.
  std::function<bool(const MercatorTile&)> has;
};

/// Makes a tile: heights of the pack up to a level, a place without height is the mean of
/// the pixels around it that have one, or 0. It is measured at the
/// samples of levels up to `measured_level`. `sampler` is the calling thread's own.
Result<RasterDemTile> make_raster_dem(const RasterDemSource& source, PackSampler& sampler,
                                      const MercatorTile& tile, int level, int measured_level);

/// The tile's 512² pixels as an RGB PNG.
Result<std::vector<std::byte>> encode_raster_dem(const RasterDemTile& tile);

}  // namespace cairn
