#include "builder/export/tile_ranges.h"

#include <map>

#include <nlohmann/json.hpp>

namespace cairn {

nlohmann::ordered_json json_of(const TileRange& r) {
  return {{"startX", r.first_x}, {"startY", r.first_y}, {"endX", r.last_x}, {"endY", r.last_y}};
}

std::vector<TileRange> TileRanges::rectangles() const {
  std::vector<TileRange> out;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> above;  // of the row before, by their columns
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> now;
  std::int64_t row = 0;
  const auto close_run = [&](std::int64_t first, std::int64_t last) {
    const std::pair run(first, last);
    const auto found = above.find(run);
    if (found != above.end() && out[found->second].last_y == row - 1) {
      out[found->second].last_y = row;
      now[run] = found->second;
      return;
    }
    now[run] = out.size();
    out.push_back({first, row, last, row});
  };
  for (auto at = tiles_.begin(); at != tiles_.end();) {
    row = at->first;
    now.clear();
    while (at != tiles_.end() && at->first == row) {
      const std::int64_t first = at->second;
      std::int64_t last = first;
      for (++at; at != tiles_.end() && at->first == row && at->second == last + 1; ++at) ++last;
      close_run(first, last);
    }
    above = now;
  }
  return out;
}

}  // namespace cairn
