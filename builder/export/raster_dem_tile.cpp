#include "builder/export/raster_dem_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <png.h>

#include "builder/export/grid_error.h"
#include "format/delaunay.h"

namespace cairn {
namespace {

constexpr int kAround = 1;                              // pixels of the tiles beside it that are read too
constexpr int kRead = kDemTilePixels + 2 * kAround;     // along a side
constexpr int kHeights = kDemTilePixels + 4 * kAround;  // and one more, to fill pixels without height

std::size_t at(int column, int row) {
  return static_cast<std::size_t>(row) * kDemTilePixels + static_cast<std::size_t>(column);
}

/// Heights at the pixels and two pixels around them; NaN where the pack has none.
Result<std::vector<double>> heights_around(const RasterDemSource& source, PackSampler& sampler,
                                           const MercatorTile& tile, int level) {
  std::vector<double> heights;
  heights.reserve(std::size_t{kHeights} * kHeights);
  for (int r = -2 * kAround; r < kDemTilePixels + 2 * kAround; ++r) {
    for (int c = -2 * kAround; c < kDemTilePixels + 2 * kAround; ++c) {
      const LonLat place = mercator_place(tile, (c + 0.5) / kDemTilePixels, (r + 0.5) / kDemTilePixels);
      const auto height = sampler.height_at(place, level);
      if (!height) return height.error();
      heights.push_back(*height ? (*height)->metres + source.shift.at(place) : std::nan(""));
    }
  }
  return heights;
}

/// The tile's own pixel that is read for one beside it, where the tile that would have it is absent.
class PixelsAround {
 public:
  PixelsAround(const RasterDemSource& source, const MercatorTile& tile) {
    const std::int64_t side = std::int64_t{1} << tile.zoom;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const MercatorTile other{tile.zoom, (tile.x + x + side) % side, tile.y + y};
        has_[index(x, y)] = (x == 0 && y == 0) || (other.y >= 0 && other.y < side && source.has(other));
      }
  }

  GridPlace read(int column, int row) const {
    if (has_[index(beyond(column), beyond(row))]) return {column, row};
    return {std::clamp(column, 0, kDemTilePixels - 1), std::clamp(row, 0, kDemTilePixels - 1)};
  }

 private:
  static int beyond(int pixel) { return pixel < 0 ? -1 : pixel >= kDemTilePixels ? 1 : 0; }
  static std::size_t index(int x, int y) { return static_cast<std::size_t>(3 * (y + 1) + x + 1); }
  std::array<bool, 9> has_{};
};

/// The height of a pixel. One without height beside some with heights is their mean, so that readings at the
/// rim of the ground are the ground's; others are 0.
double filled(const std::vector<double>& heights, int column, int row) {
  const auto height = [&](int c, int r) {
    return heights[static_cast<std::size_t>(r + 2 * kAround) * kHeights +
                   static_cast<std::size_t>(c + 2 * kAround)];
  };
  if (!std::isnan(height(column, row))) return height(column, row);
  double sum = 0;
  int count = 0;
  for (int r = row - 1; r <= row + 1; ++r) {
    for (int c = column - 1; c <= column + 1; ++c) {
      if (std::isnan(height(c, r))) continue;
      sum += height(c, r);
      ++count;
    }
  }
  return count == 0 ? 0 : sum / count;
}

}  // namespace

int dem_level(int tile_size, int zoom, int coarsest, int finest) {
  const double pixel = std::ldexp(360.0 / kDemTilePixels, -zoom);
  const double spacing = 1.0 / (tile_size - 1);
  return std::clamp(static_cast<int>(std::ceil(std::log2(spacing / pixel))), coarsest, finest);
}

int finest_dem_zoom(int tile_size, int finest) {
  const double pixels = std::log2(360.0 / kDemTilePixels * (tile_size - 1)) + finest;
  return std::max(0, static_cast<int>(std::ceil(pixels - 1e-9)));
}

DemEncoding DemEncoding::custom(double quantum_m) {
  return {"custom", 65536 * quantum_m, 256 * quantum_m, quantum_m, 8388608 * quantum_m};
}

// Rounded before it is cut into bytes.
std::uint32_t DemEncoding::pixel_of(double metres) const {
  return static_cast<std::uint32_t>(std::clamp(std::llround((metres + base_m) / blue_m), 0LL, 0xFFFFFFLL));
}

double DemEncoding::metres_of(std::uint32_t pixel) const {
  return (pixel >> 16) * red_m + (pixel >> 8 & 0xFF) * green_m + (pixel & 0xFF) * blue_m - base_m;
}

Result<RasterDemTile> make_raster_dem(const RasterDemSource& source, PackSampler& sampler,
                                      const MercatorTile& tile, int level, int measured_level) {
  const auto heights = heights_around(source, sampler, tile, level);
  if (!heights) return heights.error();
  RasterDemTile made;
  made.pixels.reserve(std::size_t{kDemTilePixels} * kDemTilePixels);
  DecodedGrid read{kRead, kRead, {}};
  const PixelsAround around(source, tile);
  for (int r = -kAround; r < kDemTilePixels + kAround; ++r) {
    for (int c = -kAround; c < kDemTilePixels + kAround; ++c) {
      const GridPlace from = around.read(c, r);
      const std::uint32_t pixel = source.encoding.pixel_of(
          filled(*heights, static_cast<int>(from.column), static_cast<int>(from.row)));
      read.metres.push_back(source.encoding.metres_of(pixel));
      if (c >= 0 && c < kDemTilePixels && r >= 0 && r < kDemTilePixels) made.pixels.push_back(pixel);
    }
  }
  const auto position = [&tile](LonLat place) {
    const double right = std::ldexp((place.lon + 180) / 360, tile.zoom) - static_cast<double>(tile.x),
                 down = std::ldexp(mercator_row(place.lat), tile.zoom) - static_cast<double>(tile.y);
    return GridPosition{right * kDemTilePixels - 0.5 + kAround, down * kDemTilePixels - 0.5 + kAround};
  };
  const auto error = grid_error(source.patches, source.tiles, source.shift,
                                ticks_around(mercator_bounds(tile)), measured_level, read, position);
  if (!error) return error.error();
  made.max_error_m = *error;
  return made;
}

Result<std::vector<std::byte>> encode_raster_dem(const RasterDemTile& tile) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(std::size_t{kDemTilePixels} * kDemTilePixels * 3);
  for (int r = 0; r < kDemTilePixels; ++r) {
    for (int c = 0; c < kDemTilePixels; ++c) {
      const std::uint32_t pixel = tile.pixels[at(c, r)];
      for (const int shift : {16, 8, 0}) rgb.push_back(static_cast<std::uint8_t>(pixel >> shift));
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = kDemTilePixels;
  image.format = PNG_FORMAT_RGB;
  // The compressed size is known only after compressing, so room for the largest is given at once.
  std::vector<std::byte> out(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t bytes = out.size();
  if (png_image_write_to_memory(&image, out.data(), &bytes, 0, rgb.data(), 0, nullptr) == 0)
    return failed(std::string("PNG: ") + image.message);
  out.resize(bytes);
  return out;
}

}  // namespace cairn
