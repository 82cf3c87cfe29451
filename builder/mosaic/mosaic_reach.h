#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "builder/mosaic/mosaic.h"
#include "cairn/geo.h"

namespace cairn {

/// The sources that samples of an area can depend on, which are those that reach it and what is looked at
/// around it. Never too few; a few more than are read. Immutable, so any thread may ask.
class MosaicReach {
 public:
  /// REQUIRES: the mosaic outlives it.
  explicit MosaicReach(const Mosaic& mosaic);

  /// A group's part of them.
  struct Members {
    std::size_t group = 0;             ///< in the mosaic
    std::vector<std::size_t> sources;  ///< in the pool, in the order in which they win
    /// Whether voids are among their posts, as far as the pool knows. These are filled from all that touches,
    /// so `sources` are all of the group.
    bool has_voids = false;
  };

  /// Returns the groups that count, in the order in which they win.
  std::vector<Members> near(const GeoBounds& area) const;

 private:
  double margin_of(std::size_t group) const;
  std::vector<std::size_t> members_near(std::size_t group, const GeoBounds& area) const;

  /// Members of a group by the cells of 1° that they touch; those of very many cells by themselves.
  struct Places {
    std::unordered_map<std::int64_t, std::vector<std::uint32_t>> by_cell;
    std::vector<std::uint32_t> large;
  };

  const Mosaic& mosaic_;
  std::vector<Places> places_;  // by group
};

}  // namespace cairn
