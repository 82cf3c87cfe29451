#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/status.h"
#include "format/rqt_steps.h"

namespace cairn {

/// The content of a block of the rqt layer.
struct RqtBlock {
  float tolerance_m = 0;  ///< of the finest triangulation; each other has twice that of the one before
  int steps = 0;          ///< how many triangulations
  RqtSteps vertices;
};

/// Returns the block (docs/pack-format.md), with one bit per visited vertex (Intel 2012, Algorithm 3).
/// A vertex is visited if it is in the next finer triangulation and its two parents are in this one. The bits
/// are compressed with zstd if that is smaller.
std::vector<std::byte> encode_rqt_block(const RqtBlock& block);

/// Decodes a block. The error is bad_data if it is no rqt block of this tile size, or if bytes are left over.
Result<RqtBlock> decode_rqt_block(std::span<const std::byte> bytes, int tile_size, bool rising);

/// Returns the number of bits before zstd, one per visited vertex. REQUIRES: the bytes decode.
std::size_t rqt_bit_count(std::span<const std::byte> bytes);

}  // namespace cairn
