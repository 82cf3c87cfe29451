#pragma once

#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <variant>

#include "cairn/loaded_tile.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Reads and decodes a tile, and returns when it is done. Called from the worker threads, several at a time.
///
/// What it returns is checked: a tile of another size, without samples or texels, and an exception are errors
/// of that tile. ErrorCode::failed says that the read may succeed later: it is repeated after growing pauses
/// for as long as the tile is needed. Any other code says that the tile's bytes are wrong: it is not read
/// again.
using ReadTile = std::function<Result<LoadedTile>(const IndexEntry& entry)>;

/// Takes the result of a read. May be called from any thread, also after the Terrain is destroyed. The first
/// call counts; if the last copy is destroyed without one, the read has failed.
using TileDone = std::function<void(Result<LoadedTile>)>;

/// Starts to read a tile and returns at once; `done` takes the tile later. Called from the thread that calls
/// Terrain::update.
///
/// `stop` is requested when the tile is no longer needed and when the Terrain is destroyed, which waits for
/// nothing. A read that stops may call `done` with any error. What ReadTile says of results holds here, too.
using RequestTile = std::function<void(const IndexEntry& entry, std::stop_token stop, TileDone done)>;

/// Where tiles come from: reads that block a worker thread each, or asynchronous ones.
using TileSource = std::variant<ReadTile, RequestTile>;

/// Returns the reader of a pack's file.
ReadTile read_from(std::shared_ptr<const PackReader> pack);

/// Decodes the bytes of a tile's block, as `IndexEntry::offset` and `bytes` say where they lie in the pack:
/// for programs that fetch them from elsewhere. bad_data where the checksum or the contents are wrong. A
/// constant tile has no block.
Result<LoadedTile> decode_tile(const IndexEntry& entry, std::span<const std::byte> block, int tile_size);

/// Returns an error unless the tile is what the entry says: its layer, size and number of samples or texels.
Status check_tile(const IndexEntry& entry, const LoadedTile& tile, int tile_size);

}  // namespace cairn
