#pragma once

// The parts of a pack, in order: header and root (16 KiB together), blocks, pages of the index, metadata.
// docs/pack-format.md explains every field; the numbers live only here and in format/index_page.h.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cairn/body.h"
#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

inline constexpr std::array<char, 8> kPackMagic = {'\x89', 'C', 'A', 'I', 'R', 'N', '\r', '\n'};
inline constexpr std::uint16_t kPackVersion = 2;
inline constexpr std::size_t kPackHeaderBytes = 256;
inline constexpr std::size_t kPackStartBytes = 16384;  ///< header and root; the blocks begin here

/// The surface that heights are measured from.
enum class VerticalDatum : std::uint8_t { unknown = 0, egm96 = 1, ellipsoid = 2 };
const char* to_string(VerticalDatum datum);

/// A hash of all bytes of a pack.
using PackId = std::array<std::byte, 16>;
std::string to_string(const PackId& id);  ///< 32 hexadecimal digits

/// The fixed-size start of the file. All offsets are from the file's first byte.
struct PackHeader {
  std::uint16_t version = kPackVersion;
  std::uint16_t tile_size = 513;  ///< samples along a tile's side: 513 or 257; texture tiles have one less
  VerticalDatum vertical_datum = VerticalDatum::unknown;
  /// The datum's name where it is none of VerticalDatum's: UTF-8, at most 39 bytes. Empty where it is.
  std::string other_datum;
  Body body;
  double quantum_m = 0.25;            ///< metres per quantum; > 0, finite
  std::uint64_t entry_count = 0;      ///< tiles of all layers
  std::uint64_t index_offset = 0;     ///< blocks lie between kPackStartBytes and here
  std::uint64_t metadata_offset = 0;  ///< the index's pages lie between index_offset and here
  std::uint64_t metadata_bytes = 0;   ///< UTF-8 JSON; it ends where the file ends
  std::uint64_t metadata_checksum = 0;
  std::uint32_t root_bytes = 0;     ///< of the root, which follows the header
  std::uint64_t root_checksum = 0;  ///< of all bytes between the header and kPackStartBytes
  PackId id{};                      ///< encode_header() works it out

  std::uint64_t file_bytes() const { return metadata_offset + metadata_bytes; }
  /// The name of the vertical datum; "unknown" where nothing is known.
  std::string_view datum_name() const {
    return other_datum.empty() ? std::string_view(to_string(vertical_datum)) : other_datum;
  }
};

/// Returns the header's bytes, with the pack's id and their own checksum.
std::array<std::byte, kPackHeaderBytes> encode_header(const PackHeader& header);
/// Accepts exactly what encode_header() writes. The error is bad_data and names the first wrong field, what
/// was expected and what was found.
Result<PackHeader> decode_header(std::span<const std::byte> bytes);

/// The kind of a tile's data. One pack may have several layers on one grid.
enum class Layer : std::uint8_t {
  heights = 0,  ///< HeightTile
  imagery = 1,  ///< TextureTile
  rqt = 2,      ///< enabled vertices of restricted quadtree triangulations (Intel 2012)
  objects = 3,  ///< ObjectTile: things that stand on the ground
  water = 4,    ///< which samples are water; docs/pack-format.md has the block
  models = 5,   ///< ObjectModel: what the objects look like, at model_address()
};
inline constexpr std::size_t kLayers = 6;
const char* to_string(Layer layer);

enum EntryFlags : std::uint16_t {
  kConstant = 1,     ///< every sample, or every texel, is min_quanta; the entry has no block
  kHasVoids = 2,     ///< heights: the block has a void mask
  kHasAlpha = 4,     ///< imagery: some texel is not opaque
  kSharedBlock = 8,  ///< the block is also that of a tile that was added earlier
  /// Never stored: the page of the index that may have the entry could not be read. Reading the tile returns
  /// the page's error.
  kUnreadable = 0x8000,
};

/// The index entry of one tile. Entries are sorted by layer and level, and within a level along a Z curve, so
/// that the four children of a tile are neighbours.
struct IndexEntry {
  Layer layer = Layer::heights;
  std::uint16_t flags = 0;
  TileId id;
  std::uint64_t offset =
      0;                    ///< of the block; 0 where there is none. Equal blocks are stored once and shared.
  std::uint32_t bytes = 0;  ///< of the block; 0 where there is none
  std::uint64_t checksum = 0;  ///< of the block; 0 where there is none
  std::int32_t min_quanta =
      0;  ///< heights: over the samples that are not void, 0 if all are. Imagery: a colour, as RGBA bytes
  std::int32_t max_quanta =
      0;  ///< heights: likewise. Imagery: peak signal-to-noise ratio in 1/1000 dB
          ///< (rqt: min and max are triangles of its coarsest and finest triangulation;
          ///< objects: min is their number; models: min is triangles of the finest level)
  /// Heights: the largest distance from the source's posts and the finest samples, never below a
  /// descendant's. Rqt: the finest triangulation is off its tile's samples by less than this. Objects: the
  /// size of the largest object in the tile or beneath it. Models: the model's size.
  float geometric_error_m = 0;
  std::uint16_t filled = 0;  ///< heights: the share of samples without a source, filled or void, in 1/65535

  friend bool operator==(const IndexEntry&, const IndexEntry&) = default;
};

/// The sums over one level of one layer, from the pack's root.
struct PackLevel {
  Layer layer = Layer::heights;
  int level = 0;
  float max_error_m = 0;             ///< the largest geometric error of its tiles
  std::uint64_t tiles = 0;           ///< at least 1
  std::uint64_t constant_tiles = 0;  ///< of these
  std::uint64_t block_bytes = 0;     ///< a block that tiles share counts for the tile that was added first

  friend bool operator==(const PackLevel&, const PackLevel&) = default;
};

}  // namespace cairn
