#include "runtime/surface/height_preparation.h"

#include <utility>

#include "runtime/surface/normal_map.h"

namespace cairn {

HeightTexels height_texels(const HeightTile& tile) {
  const auto is_gone = [&](std::size_t i) { return !tile.voids.empty() && tile.voids[i] != 0; };
  const auto [low, high] = range_of(tile);
  const std::int64_t span = static_cast<std::int64_t>(high) - low;
  HeightTexels out;
  out.base = low;
  while ((span >> out.shift) >= kVoidTexel) ++out.shift;
  out.texels.resize(tile.samples.size());
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    const std::int64_t above = static_cast<std::int64_t>(tile.samples[i]) - low;
    out.texels[i] = is_gone(i) ? kVoidTexel : static_cast<std::uint16_t>(above >> out.shift);
  }
  return out;
}

PreparedHeightTile prepare_heights(const TileId& id, std::shared_ptr<const HeightTile> tile, double quantum_m,
                                   const Ellipsoid& ellipsoid) {
  HeightTexels texels = height_texels(*tile);
  std::vector<std::byte> normals = normal_map(id, *tile, quantum_m, ellipsoid);
  return {{id, std::move(texels), std::move(normals)},
          prepare_surface_tile(id, std::move(tile), quantum_m, false, ellipsoid)};
}

void PreparedHeights::add(const TileId& id, std::shared_ptr<const HeightTile> tile, double quantum_m,
                          const Ellipsoid& ellipsoid) {
  PreparedHeightTile prepared = prepare_heights(id, std::move(tile), quantum_m, ellipsoid);
  const std::lock_guard lock(mutex_);
  ready_.insert_or_assign(id, std::move(prepared));
}

PreparedHeightTile PreparedHeights::take(const TileId& id, std::shared_ptr<const HeightTile> tile,
                                         double quantum_m, const Ellipsoid& ellipsoid) {
  {
    const std::lock_guard lock(mutex_);
    if (auto node = ready_.extract(id)) return std::move(node.mapped());
  }
  return prepare_heights(id, std::move(tile), quantum_m, ellipsoid);
}

void PreparedHeights::forget(const TileId& id) {
  const std::lock_guard lock(mutex_);
  ready_.erase(id);
}

}  // namespace cairn
