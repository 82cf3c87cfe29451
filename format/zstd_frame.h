#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "format/status.h"

namespace cairn {

/// Appends `plain` to `out` as one zstd frame that states its content size. The same bytes for the same
/// input, level and zstd version. `level` is zstd's.
void append_zstd_frame(std::span<const std::byte> plain, int level, std::vector<std::byte>& out);

/// Fills `plain` from exactly one frame. bad_data where `frame` is not one frame, whole and nothing after it,
/// of exactly that much content.
Status decode_zstd_frame(std::span<const std::byte> frame, std::span<std::byte> plain);

}  // namespace cairn
