#pragma once

#include <cstdint>

namespace cairn {

/// How samples come from posts along an axis.
enum class ResampleMethod {
  nearest,   ///< the nearest post
  bilinear,  ///< between the two posts around the sample
  cubic,     ///< Catmull-Rom through the four posts around it (Keys 1981, a = -1/2)
  exact,     ///< cubic, corrected so that the samples' linear interpolant passes through every post
  smooth,    ///< cubic of smoothed posts, corrected only where it leaves an interval around a post
};

/// What becomes of places without a source.
enum class VoidMode {
  fill,  ///< smoothly from the rim; the filled share of each tile is recorded
  keep,  ///< a mask; the runtime draws a hole
};

/// What to spend on a texture; docs/textures.md has what each gives.
enum class TextureQuality : std::uint8_t { fast, normal, best };

}  // namespace cairn
