#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cairn {

/// Which tiles around the eye's own are split for; seed [4] §6.2 unless another is named.
enum class RefinementPattern : std::uint8_t {
  normal,      ///< the quadtree path to the eye's tile
  plus,        ///< also to its 4 edge neighbours
  cross,       ///< also to its 4 diagonal neighbours: all 8 neighbours are of the finest level
  restricted,  ///< the cross rule at every level on its own: 12(K-1)+16 tiles, 10 new ones a move along an
               ///< axis, 20 along a diagonal. Tiles that touch differ by at most TWO levels, see
               ///< SceneMapSpec.
  balanced,    ///< restricted, then split on until tiles that touch differ by at most ONE level
  nine,        ///< 3×3 tiles of the finest level and no other; seed [1] §3
  window,      ///< n×n tiles of the finest level and no other; [4, Fig. 6.1.1]
};

/// All patterns, in the order of the reports, and the words for them on command lines.
std::span<const RefinementPattern> all_refinement_patterns();
std::string_view to_string(RefinementPattern pattern);
std::optional<RefinementPattern> refinement_pattern_from(std::string_view word);

}  // namespace cairn
