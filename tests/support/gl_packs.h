#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cairn/geo.h"
#include "cairn/texture_tile.h"
#include "cairn/tile_id.h"

namespace cairn::test {

/// Steep ridges, different everywhere, and as steep near the poles, where a step of a column is a centimetre:
/// quanta of 0.25 m at the samples of the grid of level kRidgesFinest, tiles of 257.
inline constexpr int kRidgesFinest = 4;
std::int32_t ridges(std::int64_t column, std::int64_t row);

/// The height of the ridges' triangles between the samples, see height_at() of a SurfaceTile.
double ridges_m(LonLat place);

/// Where packs of ridges have their finest tiles: plain land, the antimeridian, both poles, the origin.
const std::vector<LonLat>& ridge_places();

/// The whole Earth down to level -6, and down to kRidgesFinest around the places `first` to `last`.
std::vector<TileId> ridge_tiles(std::size_t first, std::size_t last);
void write_ridge_pack(const std::filesystem::path& path, std::size_t first, std::size_t last);

/// A colour in sRGB at a place.
using ColourAt = std::function<std::array<std::uint8_t, 3>(LonLat place)>;

enum class Layers { heights_and_imagery, imagery };

/// Tiles of ridges, those finer than kRidgesFinest without heights, with the colour at each texel's centre,
/// at every mip, as imagery in this format.
void write_coloured_pack(const std::filesystem::path& path, const std::vector<TileId>& tiles,
                         TextureFormat format, const ColourAt& colour,
                         Layers layers = Layers::heights_and_imagery);

/// Bakes real data, named below its folder, with tiles of 257; images without a place cover the Earth.
/// Where there is no data, false, and the test that asks says that it checks nothing.
bool bake_real_pack(const std::filesystem::path& path, const std::vector<std::string>& dems,
                    const std::vector<std::string>& images = {});

}  // namespace cairn::test
