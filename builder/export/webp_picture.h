#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// A picture as WebP, and what its compression changed.
struct WebpPicture {
  std::vector<std::byte> bytes;
  double colour_rms = 0;  ///< root mean square of red, green and blue where alpha is not 0, of 255
};

/// Compresses a square picture: RGBA, rows from the top, alpha not premultiplied. Alpha is kept exactly.
Result<WebpPicture> encode_webp(std::span<const std::uint8_t> rgba, int side);

}  // namespace cairn
