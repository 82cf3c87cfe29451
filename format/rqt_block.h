#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "format/rqt_steps.h"
#include "cairn/status.h"

namespace cairn {

/// What a block of the rqt layer holds.
struct RqtBlock {
  float tolerance_m = 0;  ///< of the finest triangulation; each of the others has twice the one before
  int steps = 0;          ///< how many triangulations
  RqtSteps vertices;
};

/// The block: docs/pack-format.md has its byte table. One bit a visited vertex [3, Algorithm 3], one whose
/// needs the triangulation has and that the one before has, too; then zstd, where that makes it shorter.
std::vector<std::byte> encode_rqt_block(const RqtBlock& block);

/// bad_data where the bytes are no such block of tiles of this size, or where bytes are left over.
Result<RqtBlock> decode_rqt_block(std::span<const std::byte> bytes, int tile_size, bool rising);

/// Bits that a block codes, before zstd: one a visited vertex. REQUIRES: bytes that decode.
std::size_t rqt_bit_count(std::span<const std::byte> bytes);

}  // namespace cairn
