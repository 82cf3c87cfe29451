#pragma once

#include <cstddef>
#include <cstdint>

namespace cairn {

/// Takes a row of a member's posts (NaN where it has none) to where a PostBlock has no value yet; `owner` is
/// the member's number there.
void fill_in_posts(const float* row, std::size_t count, std::uint16_t owner, float* heights,
                   std::uint16_t* owners);

}  // namespace cairn
