#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/pack_layout.h"

namespace cairn::test {

/// A surface known at every sample of every level: heights in quanta as a function of the sample's column
/// (from 180°W) and row (from 90°S) on the grid of level `finest`. Coarser tiles take every second sample, so
/// the levels nest.
struct TestSurface {
  int tile_size = 257;
  int finest = 2;
  std::function<std::int32_t(std::int64_t column, std::int64_t row)> height;
  std::function<bool(std::int64_t column, std::int64_t row)> is_void;  ///< may be empty: no voids

  /// The tile, with the overhang past 180°E and 90°N void.
  HeightTile tile(const TileId& id) const;
};

/// Hills without symmetry, so that no two rows, columns or tiles are alike.
std::int32_t hills(std::int64_t column, std::int64_t row);

/// An index entry with the true minimum, maximum and flags of a tile (constant, voids).
IndexEntry describe(const TileId& id, const HeightTile& tile);

PackHeader test_header(int tile_size = 257);

/// Metadata with every key that a pack's page promises and numbers that agree with the header and the
/// entries; the accuracy and the source are made up.
std::string test_metadata(const PackHeader& header, const std::vector<PackLevel>& levels);

/// Writes a pack of these tiles; every height block in the first codec of the table. The tiles' entries may
/// be changed by `edit` before they are added.
void write_test_pack(const std::filesystem::path& path, const TestSurface& surface,
                     const std::vector<TileId>& tiles,
                     const std::function<void(IndexEntry&, HeightTile&)>& edit = {});

/// The tile, its ancestors up to `coarsest`, and no others.
std::vector<TileId> with_ancestors(const std::vector<TileId>& tiles, int coarsest);

std::vector<std::byte> read_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes);

}  // namespace cairn::test
