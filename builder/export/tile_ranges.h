#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace cairn {

/// Columns and rows of tiles, both ends included.
struct TileRange {
  std::int64_t first_x = 0, first_y = 0, last_x = 0, last_y = 0;
  friend bool operator==(const TileRange&, const TileRange&) = default;
};

/// As layer.json of quantized-mesh states it.
nlohmann::ordered_json json_of(const TileRange& range);

/// A set of tiles of one level as few rectangles.
class TileRanges {
 public:
  void add(std::int64_t x, std::int64_t y) { tiles_.emplace(y, x); }

  /// They do not overlap and hold exactly the tiles that were added, by rows from the first: runs of a row,
  /// and equal runs of rows that follow each other as one.
  std::vector<TileRange> rectangles() const;

 private:
  std::set<std::pair<std::int64_t, std::int64_t>> tiles_;  // row, column
};

}  // namespace cairn
