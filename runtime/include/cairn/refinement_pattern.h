#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cairn {

/// Which neighbours of the camera's tile are refined (Melkisetoğlu 2005, §6.2, unless another source is
/// named).
enum class RefinementPattern : std::uint8_t {
  normal,      ///< none: the quadtree path to the camera's tile alone
  plus,        ///< its 4 edge neighbours
  cross,       ///< its 4 diagonal neighbours too: all 8 neighbours are of the finest level
  restricted,  ///< the cross rule at every level on its own: 12(K-1)+16 tiles, 10 new ones a move along an
               ///< axis, 20 along a diagonal. Tiles that touch differ by at most TWO levels, see
               ///< SceneMapSpec.
  balanced,    ///< restricted, then split on until tiles that touch differ by at most ONE level
  nine,        ///< 3×3 tiles of the finest level and no other (Agrawal et al. 2006, §3)
  window,      ///< n×n tiles of the finest level and no other (figure 6.1.1)
};

/// Return all patterns in the order of the reports, a pattern's name, and the pattern of a name.
std::span<const RefinementPattern> all_refinement_patterns();
std::string_view to_string(RefinementPattern pattern);
std::optional<RefinementPattern> refinement_pattern_from(std::string_view word);

}  // namespace cairn
