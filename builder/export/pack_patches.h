#pragma once

#include <optional>
#include <vector>

#include "builder/export/world_ticks.h"
#include "cairn/pack_reader.h"

namespace cairn {

/// A part of a height tile that stands for the ground: the whole tile or one quarter of it.
struct Patch {
  IndexEntry entry;
  TickRect area;       ///< in the world
  double error_m = 0;  ///< no source post in the area is farther from the tile's surface, as far as is known
};

/// Which tiles of a pack stand for the ground where an error is allowed. Immutable, so that any thread may
/// ask.
class PackPatches {
 public:
  /// `finest_error_m` is what the pack's finest surface is off at most, by its metadata. REQUIRES: the reader
  /// outlives this, and the pack has a height tile.
  PackPatches(const PackReader& pack, std::optional<double> finest_error_m);

  /// Of the pack's body.
  const Ellipsoid& ellipsoid() const { return pack_.header().body.shape; }

  int coarsest() const { return coarsest_; }
  int finest() const { return finest_; }

  /// The coarsest tiles with at most this error, or the finest that there are; none finer than `finest`. They
  /// cover all that the pack covers of the rectangle, and only tiles that share more than an edge with it
  /// come. A rectangle without width or height is a line: tiles on both sides of it come.
  std::vector<Patch> over(const TickRect& rect, double error_m, int finest) const;

  /// Likewise, but where the coarse tiles have a void the finest ones come.
  std::vector<Patch> over_with_rims(const TickRect& rect, double error_m) const;

  /// The finest tiles that have a sample within the rectangle, and those coarser ones that have no void.
  std::vector<Patch> over_rims(const TickRect& rect) const;

  /// Whether a tile of this level, or of the coarsest where this is coarser, shares more than an edge with
  /// the rectangle.
  bool has_tile(const TickRect& rect, int level) const;

  /// The finest tile up to this level that has the place, edges included, and the place's x in it, which is
  /// another one at the antimeridian. Nothing where no tile has the place.
  struct TilePlace {
    IndexEntry entry;
    std::int64_t x = 0;
  };
  std::optional<TilePlace> tile_at(std::int64_t x, std::int64_t y, int finest) const;

  /// The lowest and highest sample and the largest error of the tiles of a level, or of the nearest coarser
  /// ones, that share more than an edge with the rectangle; `complete` is false where the pack has voids
  /// there or no tile.
  struct Range {
    double lowest_m = 0;
    double highest_m = 0;
    double error_m = 0;
    bool complete = true;
  };
  Range range_over(const TickRect& rect, int level) const;

  /// What lies between the lowest and the highest sample of a tile, metres.
  double range_of(const IndexEntry& entry) const;

 private:
  /// Which tiles are good enough.
  struct Wanted {
    double error_m = 0;
    int finest = 0;
    bool whole = false;  ///< without voids
  };
  std::vector<Patch> over(const TickRect& rect, const Wanted& wanted) const;
  void descend(const IndexEntry& entry, const TickRect& rect, const Wanted& wanted,
               std::vector<Patch>& out) const;

  const PackReader& pack_;
  std::optional<double> finest_error_m_;
  int coarsest_ = 0;
  int finest_ = 0;
};

}  // namespace cairn
