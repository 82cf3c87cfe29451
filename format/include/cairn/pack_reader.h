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

/// An open pack, immutable, so that any number of threads may call it. The index is held in memory; a block
/// is one positioned read, checked: a file that is cut short while it is open gives errors.
class PackReader {
 public:
  /// Two reads: the header, then index and metadata, both checked before anything is believed.
  static Result<PackReader> open(const std::filesystem::path& path);

  PackReader(PackReader&&) noexcept;
  PackReader& operator=(PackReader&&) noexcept;
  ~PackReader();

  const std::filesystem::path& path() const;
  const PackHeader& header() const;
  std::string_view metadata_json() const;

  std::size_t entry_count() const;
  IndexEntry entry(std::size_t index) const;  ///< REQUIRES: index < entry_count()

  /// O(log n), no allocation.
  std::optional<IndexEntry> find(Layer layer, const TileId& id) const;

  /// The same, but where in the index it is.
  std::optional<std::size_t> find_index(Layer layer, const TileId& id) const;

  /// The tile itself or its nearest ancestor in the layer.
  std::optional<IndexEntry> find_nearest(Layer layer, const TileId& id) const;

  /// The coarsest and the finest level that the layer has; nullopt where it has no tile.
  struct LevelRange {
    int coarsest = 0;
    int finest = 0;
  };
  std::optional<LevelRange> levels(Layer layer) const;

  /// The block's bytes, checksum verified. Empty for a constant tile.
  Result<std::vector<std::byte>> read_block(const IndexEntry& entry) const;

  /// Reads and decodes a tile of the heights layer.
  Result<HeightTile> read_height_tile(const IndexEntry& entry) const;

 private:
  struct State;
  explicit PackReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
