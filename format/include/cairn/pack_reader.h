#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/height_tile.h"
#include "cairn/object_model.h"
#include "cairn/object_tile.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// An open pack. Immutable: any number of threads may call it. A page of the index is read when it is needed,
/// verified, and kept. A block is one positioned read and its checksum verified, so a file that is cut short
/// while it is open causes errors, no crash.
///
/// If a page of the index cannot be read, each tile that it may have counts as present, and reading that tile
/// returns the page's error (kUnreadable). Code that lists entries without reading tiles calls read_index()
/// first.
class PackReader {
 public:
  /// Opens a pack with two reads: header and root, then the metadata. Both are verified before use.
  static Result<PackReader> open(const std::filesystem::path& path);
  /// Opens a pack that is no local file. The metadata of a slow source is read when it is asked for.
  static Result<PackReader> open(std::unique_ptr<const ByteSource> source);

  PackReader(PackReader&&) noexcept;
  PackReader& operator=(PackReader&&) noexcept;
  ~PackReader();

  /// Returns the file's name, or the address of a pack that is no local file.
  const std::filesystem::path& path() const;
  const PackHeader& header() const;
  /// Returns JSON text; an empty text if that of a slow source cannot be read.
  std::string_view metadata_json() const;
  /// Reads the metadata if it has not been read. The error is why that failed.
  Status read_metadata() const;

  std::size_t entry_count() const;
  IndexEntry entry(std::size_t index) const;  ///< REQUIRES: index < entry_count()

  /// Reads the whole index, page by page, and calls `visit` with the place of each page. Ends at the first
  /// error.
  Status read_index(const std::function<void(const ByteRange&)>& visit = {}) const;

  /// Returns the tile's entry, nullopt if the layer has none. O(log n), without allocation once the pages on
  /// the way are in memory.
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

  /// Returns the sums over each level of each layer, ascending by layer, then level. The index has this order
  /// too: the entries of a level follow those of all levels before it.
  std::span<const PackLevel> level_table() const;

  /// Returns the block's bytes, their checksum verified; none for a constant tile.
  Result<std::vector<std::byte>> read_block(const IndexEntry& entry) const;

  /// Reads and decodes a tile of the heights layer.
  Result<HeightTile> read_height_tile(const IndexEntry& entry) const;

  /// Reads and decodes a tile of the objects layer; no objects for a constant one.
  Result<ObjectTile> read_object_tile(const IndexEntry& entry) const;

  /// Reads and decodes a model. The error is bad_data if the pack has none of this number.
  Result<ObjectModel> read_model(std::uint32_t model) const;
  /// Returns the number of models: they are numbered from 0.
  std::size_t model_count() const;

 private:
  struct State;
  explicit PackReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
