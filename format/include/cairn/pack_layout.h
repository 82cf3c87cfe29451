#pragma once

// The bytes of a pack, in order: the header (fixed size), the blocks with no gap between them, the index, the
// metadata, end of file. docs/pack-format.md explains every field; the numbers live only here.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

inline constexpr std::array<char, 8> kPackMagic = {'\x89', 'C', 'A', 'I', 'R', 'N', '\r', '\n'};
inline constexpr std::uint16_t kPackVersion = 1;
inline constexpr std::size_t kPackHeaderBytes = 96;
inline constexpr std::size_t kIndexEntryBytes = 48;

/// The surface that heights are measured from.
enum class VerticalDatum : std::uint8_t { unknown = 0, egm96 = 1, ellipsoid = 2 };
const char* to_string(VerticalDatum datum);

/// The fixed-size start of the file. All offsets are from the file's first byte.
struct PackHeader {
  std::uint16_t version = kPackVersion;
  std::uint16_t tile_size = 513;  ///< samples along a tile's side: 513 or 257; texture tiles have one less
  VerticalDatum vertical_datum = VerticalDatum::unknown;
  double quantum_m = 0.25;         ///< metres per quantum; > 0, finite
  std::uint64_t index_offset = 0;  ///< blocks lie between the header and here
  std::uint64_t index_count = 0;   ///< entries
  std::uint64_t index_checksum = 0;
  std::uint64_t metadata_offset = 0;  ///< = index_offset + index_count · kIndexEntryBytes
  std::uint64_t metadata_bytes = 0;   ///< UTF-8 JSON; it ends where the file ends
  std::uint64_t metadata_checksum = 0;

  std::uint64_t file_bytes() const { return metadata_offset + metadata_bytes; }
};

/// Returns the header's bytes, with their own checksum.
std::array<std::byte, kPackHeaderBytes> encode_header(const PackHeader& header);
/// Accepts exactly what encode_header() writes. The error is bad_data and names the first wrong field, what
/// was expected and what was found.
Result<PackHeader> decode_header(std::span<const std::byte> bytes);

/// The kind of a tile's data. One pack may have several layers on one grid.
enum class Layer : std::uint8_t {
  heights = 0,  ///< HeightTile
  imagery = 1,  ///< TextureTile
  rqt = 2,      ///< enabled vertices of restricted quadtree triangulations (Intel 2012)
};
const char* to_string(Layer layer);

enum EntryFlags : std::uint16_t {
  kConstant = 1,  ///< every sample, or every texel, is min_quanta; the entry has no block
  kHasVoids = 2,  ///< heights: the block has a void mask
  kHasAlpha = 4,  ///< imagery: some texel is not opaque
};

/// The index entry of one tile. Entries are sorted by layer, then TileId, for binary search.
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
  std::int32_t max_quanta = 0;  ///< heights: likewise. Imagery: peak signal-to-noise ratio in 1/1000 dB
                                ///< (rqt: min and max are triangles of its coarsest and finest triangulation)
  /// Heights: the largest distance from the source's posts and the finest samples, never below a
  /// descendant's. Rqt: the finest triangulation is off its tile's samples by less than this.
  float geometric_error_m = 0;
  std::uint16_t filled = 0;  ///< heights: the share of samples without a source, filled or void, in 1/65535

  friend bool operator==(const IndexEntry&, const IndexEntry&) = default;
};

/// Returns whether a comes before b in the index.
inline bool entry_before(const IndexEntry& a, const IndexEntry& b) {
  return a.layer != b.layer ? a.layer < b.layer : a.id < b.id;
}

void append_entry(const IndexEntry& entry, std::vector<std::byte>& out);
/// Decodes an entry. The error is bad_data if a field is out of range. REQUIRES: bytes.size() ==
/// kIndexEntryBytes.
Result<IndexEntry> decode_entry(std::span<const std::byte> bytes);

}  // namespace cairn
