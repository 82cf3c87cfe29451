#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

/// A rectangle of a lattice's posts as the mosaic has decided them, rows from south to north.
struct PostBlock {
  /// Who gave a post its value.
  static constexpr std::uint16_t kOutside = 0;    ///< no source reaches here
  static constexpr std::uint16_t kVoid = 0xFFFF;  ///< a source reaches here, but none has a value
  // otherwise 1 + the member's number in its group

  std::int64_t i0 = 0;  ///< lattice index of the south-west post
  std::int64_t j0 = 0;
  int columns = 0;
  int rows = 0;
  std::vector<float> heights;         ///< metres; NaN where there is no value
  std::vector<std::uint16_t> owners;  ///< as above

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  static bool has_value(std::uint16_t owner) { return owner != kOutside && owner != kVoid; }
};

}  // namespace cairn
