#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <unordered_map>
#include <vector>

#include "cairn/pack_reader.h"

namespace cairn::test {

/// The imagery of a pack, decoded.
class TexturePack {
 public:
  explicit TexturePack(const std::filesystem::path& path);

  const PackReader& pack() const { return pack_; }
  int size() const { return pack_.header().tile_size - 1; }
  int finest() const { return pack_.levels(Layer::imagery)->finest; }

  using Mips = std::vector<std::vector<std::uint8_t>>;  // RGBA
  /// Null where there is no such tile.
  const Mips* mips(const TileId& id);

  /// The texel `dx` east and `dy` south of the one that holds the place, at the finest level; nullopt where
  /// there is no tile or the texel is not opaque.
  std::optional<std::array<int, 3>> colour(LonLat place, int dx = 0, int dy = 0);

 private:
  PackReader pack_;
  std::unordered_map<TileId, Mips> tiles_;
};

/// Mean absolute differences of R, G, B between opaque texels side by side at one mip, over all
/// pairs of tiles of a level, or of all levels.
struct SeamDifferences {
  double across = 0;      ///< the two sides of an edge between tiles
  double beside = 0;      ///< the texel at such an edge and the next one inwards
  double inside = 0;      ///< neighbours inside tiles
  std::size_t pairs = 0;  ///< of texels across edges
};
SeamDifferences seam_differences(TexturePack& pack, std::optional<int> level, int mip);

}  // namespace cairn::test
