#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "cairn/drape.h"
#include "cairn/tile_id.h"

namespace cairn {

/// A piece of a line as a patch shows it: the shader's own layout.
struct DrapedSegment {
  glm::vec4 ends{0};              ///< of the patch, 0…1 from its south-west corner: x, y, x, y
  glm::vec4 colour_and_width{0};  ///< linear RGB; pixels
};
static_assert(sizeof(DrapedSegment) == 32);

/// The lines of a drape by the patches that they cross. One thread only.
class DrapeIndex {
 public:
  explicit DrapeIndex(std::shared_ptr<const Drape> drape);

  /// Returns the pieces of lines in a patch and a quarter of its width around it, in the lines' order. Places
  /// closer than `least` of the patch's width may be left out, so that no piece is off by more. They hold
  /// until the next call.
  std::span<const DrapedSegment> in(const TileId& patch, double least);

  const Drape& drape() const { return *drape_; }

 private:
  /// Pieces first…last of a line, turned by so many degrees: piece i is from place i to place i + 1.
  struct Run {
    std::uint32_t line = 0;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    double turn_deg = 0;
  };
  const std::vector<Run>& runs_in(const TileId& area);
  glm::dvec2 place(const Run& run, std::uint32_t index) const;
  void append(const Run& run, const TileId& patch, double least, std::vector<DrapedSegment>& out) const;

  std::shared_ptr<const Drape> drape_;
  std::vector<std::vector<glm::dvec2>> places_;  // longitudes unwrapped; a point twice
  std::unordered_map<TileId, std::vector<Run>> runs_;
  struct Kept {
    int least_log2 = 0;
    std::vector<DrapedSegment> segments;
  };
  std::unordered_map<TileId, Kept> kept_;
};

}  // namespace cairn
