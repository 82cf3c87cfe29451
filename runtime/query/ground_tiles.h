#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/pack_reader.h"

namespace cairn {

/// A rectangle of cells of a tile, first and last included.
struct CellRange {
  int west = 0;
  int south = 0;
  int east = 0;
  int north = 0;
};

/// A decoded tile with the highest samples of its cells, of 2×2 cells, of 4×4 and so on.
class GroundTile {
 public:
  /// `pack`: the header of the pack that the tile is of.
  GroundTile(const IndexEntry& entry, HeightTile tile, const PackHeader& pack);

  const IndexEntry& entry() const { return entry_; }
  /// A place's position in sample intervals from the south-west corner. REQUIRES: the tile holds the place.
  struct Position {
    double column = 0;
    double row = 0;
    int cell_column = 0;
    int cell_row = 0;
  };
  Position position_of(LonLat place) const;

  /// Metres; nullopt where a sample of the cell that has weight is void.
  std::optional<double> height_m(const Position& at) const;
  /// The upward unit normal in geocentric axes; nullopt where a sample of the cell is void.
  std::optional<glm::dvec3> normal(LonLat place) const;

  /// A height that the ground of the cells does not exceed, and exceeds by nothing where the cells are few;
  /// minus infinity where they are void.
  double ceiling_m(const CellRange& cells) const;

 private:
  struct Maxima {
    int side = 0;
    std::vector<std::int32_t> highest;
  };

  IndexEntry entry_;
  HeightTile tile_;
  double quantum_m_;
  Ellipsoid ellipsoid_;
  std::vector<Maxima> maxima_;  // of cells, then of 2×2 of the ones before
};

/// The finest tiles of a pack's heights, the last ones in memory. One thread only.
class GroundTiles {
 public:
  GroundTiles(std::shared_ptr<const PackReader> pack, std::size_t most_tiles);

  const PackReader& pack() const { return *pack_; }
  /// The finest tile that holds the place; null where there is none. Holds until the next call.
  Result<const GroundTile*> at(LonLat place);

  /// A height that no ground within so many degrees of a place exceeds; minus infinity where there is none.
  /// With `errors`, the ground's own errors are added.
  Result<double> ceiling_m(LonLat place, double lon_reach, double lat_reach, bool errors);

 private:
  Result<const GroundTile*> tile(const IndexEntry& entry);
  bool has_children(const TileId& id) const;
  Result<double> ceiling_in(const TileId& id, LonLat place, double lon_reach, double lat_reach, bool errors);

  std::shared_ptr<const PackReader> pack_;
  std::size_t most_tiles_;
  double highest_m_;             // above all ground and its errors
  std::list<GroundTile> tiles_;  // latest use first
};

}  // namespace cairn
