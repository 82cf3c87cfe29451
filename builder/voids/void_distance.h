#pragma once

#include <vector>

#include "builder/resample/post_block.h"

namespace cairn {

/// By post of the block: how many posts it is to the nearest one with a value, along the axis where it is
/// farther; `most` where it is that or more.
std::vector<int> distances_to_values(const PostBlock& block, int most);

/// The distance at a place of the block, in posts from its first one, interpolated between the four around.
/// REQUIRES: these lie in the block.
double distance_at(const PostBlock& block, const std::vector<int>& distances, double column, double row);

}  // namespace cairn
