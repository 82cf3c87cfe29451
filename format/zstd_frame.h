#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// Parameters of zstd's search for repetitions; 0 is the level's default.
struct ZstdSearch {
  int level = 1;
  int hash_log = 0;
  int min_match = 0;
};

/// Appends `plain` to `out` as one zstd frame with its content size. Equal inputs, parameters and zstd
/// versions give equal bytes.
void append_zstd_frame(std::span<const std::byte> plain, const ZstdSearch& search,
                       std::vector<std::byte>& out);

/// Decodes one frame into `plain`. The error is bad_data if `frame` is not exactly one whole frame of that
/// content size.
Status decode_zstd_frame(std::span<const std::byte> frame, std::span<std::byte> plain);

}  // namespace cairn
