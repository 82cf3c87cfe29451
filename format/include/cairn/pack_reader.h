#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// An open pack. Immutable: any number of threads may call it. The index is kept in memory; a block is one
/// positioned read and its checksum verified, so a file that is cut short while it is open causes errors, no
/// crash.
class PackReader {
 public:
  /// Opens a pack with two reads: the header, then index and metadata. Both are verified before use.
  static Result<PackReader> open(const std::filesystem::path& path);

  PackReader(PackReader&&) noexcept;
  PackReader& operator=(PackReader&&) noexcept;
  ~PackReader();

  const std::filesystem::path& path() const;
  const PackHeader& header() const;
  std::string_view metadata_json() const;

  std::size_t entry_count() const;
  IndexEntry entry(std::size_t index) const;  ///< REQUIRES: index < entry_count()

  /// Returns the tile's entry, nullopt if the layer has none. O(log n), without allocation.
  std::optional<IndexEntry> find(Layer layer, const TileId& id) const;

  /// Returns the tile's place in the index, nullopt if the layer has none.
  std::optional<std::size_t> find_index(Layer layer, const TileId& id) const;

  /// Returns the entry of the tile or of its nearest ancestor in the layer, nullopt if there is none.
  std::optional<IndexEntry> find_nearest(Layer layer, const TileId& id) const;

  /// The coarsest and the finest level of a layer.
  struct LevelRange {
    int coarsest = 0;
    int finest = 0;
  };
  /// Returns nullopt if the layer has no tile.
  std::optional<LevelRange> levels(Layer layer) const;

  /// Returns the block's bytes, their checksum verified; none for a constant tile.
  Result<std::vector<std::byte>> read_block(const IndexEntry& entry) const;

  /// Reads and decodes a tile of the heights layer.
  Result<HeightTile> read_height_tile(const IndexEntry& entry) const;

 private:
  struct State;
  explicit PackReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
