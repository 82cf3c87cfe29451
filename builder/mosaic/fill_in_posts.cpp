#include "builder/mosaic/fill_in_posts.h"

#include "builder/resample/post_block.h"
#include "format/simd_clones.h"

namespace cairn {

CAIRN_SIMD_CLONES void fill_in_posts(const float* row, std::size_t count, std::uint16_t owner, float* heights,
                                     std::uint16_t* owners) {
  for (std::size_t c = 0; c < count; ++c) {  // no branches, so that the loop is one of vectors
    const bool taken = PostBlock::has_value(owners[c]);
    const bool is_void = row[c] != row[c];
    const std::uint16_t next = is_void ? PostBlock::kVoid : owner;
    heights[c] = taken ? heights[c] : row[c];
    owners[c] = taken ? owners[c] : next;
  }
}

}  // namespace cairn
