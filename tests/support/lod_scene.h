#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <random>

#include "runtime/lod/lod_method.h"
#include "tests/support/test_pack.h"

namespace cairn::test {

/// Scenes of small tiles of mixed levels, some drawn from an ancestor, over a made-up surface.
class LodScenes {
 public:
  static constexpr int kTileSize = 33;
  static constexpr int kFinest = 5;

  /// `shifted_fillers`: some samples are void, and tiles disagree about what is under them.
  explicit LodScenes(bool shifted_fillers = false);

  /// 2×2 tiles of level 1 around the place, split at random up to four times.
  LodScene around(LonLat middle, std::mt19937& random);

 private:
  void split(const TileId& area, const TileId& source, std::mt19937& random, LodScene& scene);
  LodTile tile(const TileId& area, const TileId& source);
  std::shared_ptr<const HeightTile> heights(const TileId& id);

  TestSurface surface_;
  bool shifted_fillers_;
  std::map<TileId, std::shared_ptr<const HeightTile>> heights_;
};

/// A place of a mesh: the corners of a triangle on which it lies, and their shares, whose sum is 1.
struct MeshPlace {
  std::array<LodVertex, 3> corners;
  std::array<double, 3> shares;
};

/// Finds a place by trying every triangle; nullopt where none has it.
std::optional<MeshPlace> find_on(const LodMesh& mesh, const LatticePoint& place);

/// A view of the place from 10 m to 1000 km above it, in any direction.
ViewState random_view(LonLat near, std::mt19937& random);

}  // namespace cairn::test
