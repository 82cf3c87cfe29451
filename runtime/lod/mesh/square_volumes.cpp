#include "runtime/lod/mesh/square_volumes.h"

#include <algorithm>

#include "cairn/geodesy.h"

namespace cairn {

SquareVolumes::SquareVolumes(const LodScene& scene, const LodTile& tile, int least)
    : levels_(std::bit_width(static_cast<unsigned>(tile.heights->size - 1)) - 1),
      least_(std::min(least, levels_)) {
  for (int k = least_; k <= levels_; ++k) volumes_.emplace_back(std::size_t{1} << (2 * (levels_ - k)));
  measure(*tile.heights, scene.quantum_m);
  place(tile.source, Occluder(scene.lowest_m, scene.ellipsoid));
}

void SquareVolumes::measure(const HeightTile& heights, double quantum_m) {
  const int n = 1 << least_, squares = 1 << (levels_ - least_);
  std::size_t i = 0;
  for (int y = 0; y < squares; ++y) {
    for (int x = 0; x < squares; ++x, ++i) {
      std::int32_t low = heights.at(x * n, y * n), high = low;
      for (int r = y * n; r <= (y + 1) * n; ++r) {
        for (int c = x * n; c <= (x + 1) * n; ++c) {
          low = std::min(low, heights.at(c, r));
          high = std::max(high, heights.at(c, r));
        }
      }
      volumes_[0][i].low_m = low * quantum_m;
      volumes_[0][i].high_m = high * quantum_m;
    }
  }
  for (int k = least_ + 1; k <= levels_; ++k) {
    std::vector<SquareVolume>& level = volumes_[static_cast<std::size_t>(k - least_)];
    for (std::size_t s = 0; s < level.size(); ++s) {
      const int x = static_cast<int>(s) & ((1 << (levels_ - k)) - 1),
                y = static_cast<int>(s) >> (levels_ - k);
      level[s].low_m = at(k - 1, 2 * x, 2 * y).low_m;
      level[s].high_m = at(k - 1, 2 * x, 2 * y).high_m;
      for (int q = 1; q < 4; ++q) {
        const SquareVolume& quarter = at(k - 1, 2 * x + (q & 1), 2 * y + (q >> 1));
        level[s].low_m = std::min(level[s].low_m, quarter.low_m);
        level[s].high_m = std::max(level[s].high_m, quarter.high_m);
      }
    }
  }
}

void SquareVolumes::place(const TileId& id, const Occluder& occluder) {
  const LatticePoint corner = south_west_of(id);
  for (int k = least_; k <= levels_; ++k) {
    const std::int64_t width = lattice_width(id.level) >> (levels_ - k);
    for (int y = 0; y < 1 << (levels_ - k); ++y) {
      for (int x = 0; x < 1 << (levels_ - k); ++x) {
        const LonLat low = place_of({corner.x + x * width, corner.y + y * width});
        const LonLat high = place_of({corner.x + (x + 1) * width, corner.y + (y + 1) * width});
        if (low.lon >= 180 || low.lat >= 90) continue;
        SquareVolume& square =
            volumes_[static_cast<std::size_t>(k - least_)]
                    [(static_cast<std::size_t>(y) << (levels_ - k)) + static_cast<std::size_t>(x)];
        square.volume =
            bounding_volume({low.lon, low.lat, high.lon, high.lat}, square.low_m, square.high_m, occluder);
      }
    }
  }
}

std::uint64_t SquareVolumes::bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& level : volumes_) bytes += level.size() * sizeof(SquareVolume);
  return bytes;
}

}  // namespace cairn
