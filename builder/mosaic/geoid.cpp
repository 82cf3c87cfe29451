#include "builder/mosaic/geoid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn {
namespace {

std::array<double, 4> catmull_rom(double t) {
  return {((2 - t) * t - 1) * t / 2, ((3 * t - 5) * t * t + 2) / 2, ((4 - 3 * t) * t + 1) * t / 2,
          (t - 1) * t * t / 2};
}

}  // namespace

Result<Geoid> Geoid::open(const std::filesystem::path& path) {
  auto raster = open_raster(path, {});
  if (!raster) return raster.error();
  const RasterInfo& info = (*raster)->info();
  const auto placement = place_on_lattice(info);
  const auto around = placement ? placement->lattice.posts_around() : std::nullopt;
  if (!around || info.columns < *around) {
    return bad_data(path.string() + ": geoid: expected a lat/long raster around the Earth, found " +
                    std::to_string(info.bounds.width()) + " degrees of longitude");
  }
  Geoid geoid;
  geoid.placement_ = *placement;
  geoid.columns_ = info.columns;
  geoid.rows_ = info.rows;
  geoid.posts_.resize(static_cast<std::size_t>(info.columns * info.rows));
  if (auto read = (*raster)->read_heights({0, 0, info.columns, info.rows}, geoid.posts_); !read)
    return read.error();
  if (std::any_of(geoid.posts_.begin(), geoid.posts_.end(), [](float h) { return std::isnan(h); })) {
    return bad_data(path.string() + ": geoid: expected a value at every post, found voids");
  }
  if (placement->north_up) {
    for (std::int64_t j = 0; j < info.rows / 2; ++j) {
      std::swap_ranges(geoid.posts_.begin() + j * info.columns, geoid.posts_.begin() + (j + 1) * info.columns,
                       geoid.posts_.begin() + (info.rows - 1 - j) * info.columns);
    }
  }
  return geoid;
}

float Geoid::post(std::int64_t i, std::int64_t j) const {
  const std::int64_t around = *placement_.lattice.posts_around();
  const std::int64_t column = ((i - placement_.i0) % around + around) % around;
  const std::int64_t row = std::clamp<std::int64_t>(j - placement_.j0, 0, rows_ - 1);
  return posts_[static_cast<std::size_t>(row * columns_ + column)];
}

double Geoid::undulation(LonLat place) const {
  const Lattice& lattice = placement_.lattice;
  const double x = (place.lon + 180.0) * lattice.lon.posts_per_degree - lattice.lon.phase;
  const double y = (place.lat + 90.0) * lattice.lat.posts_per_degree - lattice.lat.phase;
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const auto wx = catmull_rom(x - static_cast<double>(i));
  const auto wy = catmull_rom(y - static_cast<double>(j));
  double sum = 0;
  for (int b = 0; b < 4; ++b) {
    double row = 0;
    for (int a = 0; a < 4; ++a)
      row += wx[static_cast<std::size_t>(a)] * static_cast<double>(post(i + a - 1, j + b - 1));
    sum += wy[static_cast<std::size_t>(b)] * row;
  }
  return sum;
}

}  // namespace cairn
