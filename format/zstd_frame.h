#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// How zstd looks for repetitions, in its own parameters; 0 is the level's own.
struct ZstdSearch {
  int level = 1;
  int hash_log = 0;
  int min_match = 0;
};

/// Appends `plain` to `out` as one zstd frame that states its content size. The same bytes for the same
/// input, search and zstd version.
void append_zstd_frame(std::span<const std::byte> plain, const ZstdSearch& search,
                       std::vector<std::byte>& out);

/// Fills `plain` from exactly one frame. bad_data where `frame` is not one frame, whole and nothing after it,
/// of exactly that much content.
Status decode_zstd_frame(std::span<const std::byte> frame, std::span<std::byte> plain);

}  // namespace cairn
