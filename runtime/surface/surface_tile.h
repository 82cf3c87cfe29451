#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"
#include "runtime/view/sample_lattice.h"

namespace cairn::gl {

/// The largest log2 of intervals along a tile's side: 513 samples.
inline constexpr int kMaxCellsLog2 = 9;

/// log2 of the intervals along the side of a tile: 9 or 8. REQUIRES: 513 or 257.
int cells_log2_of(int tile_size);

/// How far the surface of a tile is from what is left of it when only every 2^k-th row and column are kept,
/// k = 0…9: an upper bound in metres, the sum over the steps of the largest deviation that the step adds. The
/// surface is that of triangles whose diagonals run from south-west to north-east. Entries beyond the tile's
/// last step repeat it.
using DecimationErrors = std::array<float, kMaxCellsLog2 + 1>;

/// A block is 64×64 cells of a tile: the most that one grid draws, and what a grid is chosen for.
inline constexpr int kBlockCellsLog2 = 6;

/// What is known of a part of a tile before it is drawn.
struct Relief {
  float low_m = 0;  ///< no sample that is not void is outside these
  float high_m = 0;
  DecimationErrors errors{};
};

/// Of a tile as a whole, and of each of its blocks.
struct TileRelief {
  Relief whole;
  std::vector<Relief>
      blocks;  ///< row-major from the south-west; no entry of their errors beyond k = 6 counts
};
TileRelief relief_of(const HeightTile& tile, double quantum_m);

/// Heights as a GPU stores them: quanta = base + (texel << shift). 65535 is a void.
struct HeightTexels {
  std::int32_t base = 0;
  int shift = 0;                      ///< 0 unless the tile spans more than 65534 quanta: 16 km at 0.25 m
  std::vector<std::uint16_t> texels;  ///< as HeightTile::samples
};
HeightTexels height_texels(const HeightTile& tile);
inline constexpr std::uint16_t kVoidTexel = 65535;

/// What the renderer keeps of a tile of heights on the CPU.
struct SurfaceTile {
  TileId id;
  std::shared_ptr<const HeightTile> heights;
  double quantum_m = 0;
  bool exact_on_gpu = true;  ///< the texels give the heights of height_at(), to the last bit
  TileRelief relief;

  /// Of the block that holds the area, of the whole tile where that is larger. REQUIRES: the tile covers it.
  const Relief& relief_under(const TileId& area) const;
};

/// The height in metres of the triangles between the samples, whose diagonals run from south-west to
/// north-east; along an edge that tiles share the same from each of them; NaN where a sample that it needs is
/// void. A sample is float(quanta)·float(quantum). REQUIRES: the point lies in the
/// tile, edges included.
float height_at(const SurfaceTile& tile, const LatticePoint& point);

/// A tile's surface, shown with less detail than it has. At a whole level it is that of the ancestor of the
/// level: samples nest, so it is the tile's own with only every 2nd, 4th, … row and column kept. Between two
/// levels a height is that far between theirs.
struct ShownSurface {
  const SurfaceTile* tile = nullptr;  ///< null: height 0 everywhere
  double detail = 0;  ///< the tile's level or less, but not so little that no cell is left of it

  /// Of the tile with so much detail as it can be shown with, `detail` at most.
  static ShownSurface of(const SurfaceTile* tile, double detail);
  /// The finest level all of whose samples are shown as they are.
  int whole_level() const;
};

/// The same of a shown surface. Where a level's sample is void, the next finer level stands in.
/// REQUIRES: there is a tile.
float height_at(const ShownSurface& surface, const LatticePoint& point);

}  // namespace cairn::gl
