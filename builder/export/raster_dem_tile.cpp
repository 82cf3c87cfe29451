#include "builder/export/raster_dem_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
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

LonLat pixel_place(const MercatorTile& tile, double column, double row) {
  return mercator_place(tile, (column + 0.5) / kDemTilePixels, (row + 0.5) / kDemTilePixels);
}

/// Heights at the pixels and two pixels around them; NaN where the pack has none.
class PixelHeights {
 public:
  PixelHeights(const RasterDemSource& source, PackSampler& sampler, const MercatorTile& tile, int level)
      : source_(source), sampler_(sampler), tile_(tile), level_(level) {}

  Status read() {
    heights_.reserve(std::size_t{kHeights} * kHeights);
    for (int r = -2 * kAround; r < kDemTilePixels + 2 * kAround; ++r) {
      for (int c = -2 * kAround; c < kDemTilePixels + 2 * kAround; ++c) {
        const auto height = height_at(c, r);
        if (!height) return height.error();
        heights_.push_back(*height);
      }
    }
    return {};
  }

  /// The height of a pixel. One without height beside some with heights has that of the ground's rim towards
  /// them, so that readings at the rim are the ground's; others are 0.
  Result<double> filled(int column, int row) {
    if (const double height = at_pixel(column, row); !std::isnan(height)) return height;
    constexpr std::array<std::array<int, 2>, 8> kSteps{
        {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
    // Where ground lies straight beside it, what lies across a corner is farther off.
    for (const auto& steps : {std::span(kSteps).first(4), std::span(kSteps).last(4)}) {
      double sum = 0;
      int count = 0;
      for (const auto& [c, r] : steps) {
        if (std::isnan(at_pixel(column + c, row + r))) continue;
        const auto rim = rim_height(column, row, c, r);
        if (!rim) return rim.error();
        sum += *rim;
        ++count;
      }
      if (count > 0) return sum / count;
    }
    return 0.0;
  }

 private:
  double at_pixel(int column, int row) const {
    return heights_[static_cast<std::size_t>(row + 2 * kAround) * kHeights +
                    static_cast<std::size_t>(column + 2 * kAround)];
  }

  Result<double> height_at(double column, double row) {
    const LonLat place = pixel_place(tile_, column, row);
    const auto height = sampler_.height_at(place, level_);
    if (!height) return height.error();
    return *height ? (*height)->metres + source_.shift.at(place) : std::nan("");
  }

  /// Returns the height at the end of the ground on the way to a pixel from the one beside it.
  Result<double> rim_height(int column, int row, int to_column, int to_row) {
    constexpr int kHalvings = 10;  // to a thousandth of a pixel
    double known = at_pixel(column + to_column, row + to_row);
    double ground = 1, none = 0;  // pixels from the one without height
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (ground + none) / 2;
      const auto height = height_at(column + middle * to_column, row + middle * to_row);
      if (!height) return height.error();
      (std::isnan(*height) ? none : ground) = middle;
      if (!std::isnan(*height)) known = *height;
    }
    return known;
  }

  const RasterDemSource& source_;
  PackSampler& sampler_;
  const MercatorTile& tile_;
  int level_;
  std::vector<double> heights_;
};

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
  PixelHeights heights(source, sampler, tile, level);
  if (auto status = heights.read(); !status) return status.error();
  RasterDemTile made;
  made.pixels.reserve(std::size_t{kDemTilePixels} * kDemTilePixels);
  DecodedGrid read{kRead, kRead, {}};
  const PixelsAround around(source, tile);
  for (int r = -kAround; r < kDemTilePixels + kAround; ++r) {
    for (int c = -kAround; c < kDemTilePixels + kAround; ++c) {
      const GridPlace from = around.read(c, r);
      const auto height = heights.filled(static_cast<int>(from.column), static_cast<int>(from.row));
      if (!height) return height.error();
      const std::uint32_t pixel = source.encoding.pixel_of(*height);
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
