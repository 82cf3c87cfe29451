#include "builder/resample/axis_weights.h"

#include <algorithm>

namespace cairn {

void AxisWeights::append(std::int64_t first_post, std::span<const double> row) {
  rows.push_back(
      {first_post, static_cast<std::int32_t>(weights.size()), static_cast<std::int32_t>(row.size())});
  weights.insert(weights.end(), row.begin(), row.end());
}

std::span<const double> AxisWeights::weights_of(const Row& row) const {
  return std::span(weights).subspan(static_cast<std::size_t>(row.offset),
                                    static_cast<std::size_t>(row.count));
}

IndexRange posts_of(std::span<const AxisWeights::Row> rows) {
  IndexRange posts{rows.front().first, rows.front().first};
  for (const AxisWeights::Row& row : rows) {
    posts.first = std::min(posts.first, row.first);
    posts.last = std::max(posts.last, row.first + row.count - 1);
  }
  return posts;
}

}  // namespace cairn
