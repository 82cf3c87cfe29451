#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "builder/bake/tile_layer.h"
#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

/// What a part holds of one unit: all that a merge has to write for it, in the order in which a bake of the
/// whole would write it.
struct PartRecord {
  Layer layer = Layer::heights;
  TileId unit;
  std::vector<TileBlock> blocks;          ///< to be written now, in this order
  std::vector<std::byte> root;            ///< of the unit's subtree, as its layer writes it
  std::optional<TileBlock> held;          ///< what is stored of the unit's own tile, unless `blocks` has it
  std::vector<std::byte> subtree_root;    ///< where a subtree of the shard ends with this unit, and is larger
  std::optional<TileBlock> subtree_held;  ///< what is stored of that root, which is not written yet
  bool ends_subtree = false;              ///< the unit is the last one of a subtree, or is one itself
};

/// Returns the record as bytes, without a checksum.
std::vector<std::byte> encode_part_record(const PartRecord& record);

/// The inverse. The error is bad_data where the bytes are too few or too many, or say what cannot be.
Result<PartRecord> decode_part_record(std::span<const std::byte> bytes);

}  // namespace cairn
