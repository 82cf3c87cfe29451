// usage: cairn-projected-bench SAMPLES_PER_DEGREE TOLERANCE_M RASTER
//
// A projected raster resampled tile by tile: rounds, residuals and time, how much neighbouring tiles disagree
// on their common edge, and the post error of the surface that is put together from them.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "builder/raster/raster_source.h"
#include "builder/resample/resample_projected.h"
#include "builder/voids/void_fill.h"

namespace {

using namespace cairn;

constexpr std::int64_t kTile = 512;
constexpr std::int64_t kHalo = ProjectedResampler::kHalo;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Raster {
  Georeference georeference;
  IndexWindow window;
  std::vector<float> heights;
  FillPyramid pyramid;
};

Result<Raster> read(const char* path) {
  auto source = open_raster(path, {});
  if (!source) return source.error();
  const RasterInfo& info = (*source)->info();
  Raster raster{info.georeference, {{0, info.columns - 1}, {0, info.rows - 1}}, {}, {}};
  raster.heights.resize(static_cast<std::size_t>(raster.window.count()));
  if (auto status = (*source)->read_heights({0, 0, info.columns, info.rows}, raster.heights); !status) {
    return status.error();
  }
  FillPyramidBuilder builder(raster.window);
  builder.add(raster.window, raster.heights);
  raster.pyramid = builder.complete();
  return raster;
}

std::vector<float> complete_posts(const Raster& raster, IndexWindow window) {
  const IndexWindow around = posts_to_fill(window);
  std::vector<float> posts(static_cast<std::size_t>(around.count()), std::numeric_limits<float>::quiet_NaN());
  const IndexWindow& whole = raster.window;
  const IndexRange columns{std::max(around.x.first, whole.x.first), std::min(around.x.last, whole.x.last)};
  for (std::int64_t y = std::max(around.y.first, whole.y.first); y <= std::min(around.y.last, whole.y.last);
       ++y) {
    if (columns.count() <= 0) break;
    std::copy_n(&raster.heights[whole.offset(columns.first, y)], columns.count(),
                &posts[around.offset(columns.first, y)]);
  }
  std::vector<float> out(static_cast<std::size_t>(window.count()));
  fill_voids(raster.pyramid, posts, window, out);
  return out;
}

// Which posts of the window the raster has.
std::vector<std::uint8_t> posts_of(const Raster& raster, IndexWindow window) {
  std::vector<std::uint8_t> has;
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x)
      has.push_back(raster.window.x.holds(x) && raster.window.y.holds(y) ? 1 : 0);
  }
  return has;
}

struct TileAt {
  std::int64_t x = 0;
  std::int64_t y = 0;
  auto operator<=>(const TileAt&) const = default;
};

IndexWindow window_of(TileAt tile) {
  return {{tile.x * kTile - kHalo, (tile.x + 1) * kTile + kHalo},
          {tile.y * kTile - kHalo, (tile.y + 1) * kTile + kHalo}};
}

struct Place {
  double x = 0;
  double y = 0;
};

Place place_of(const Raster& raster, double samples_per_degree, std::int64_t column, std::int64_t row) {
  const LonLat at = raster.georeference.place_of(static_cast<double>(column), static_cast<double>(row));
  return {(at.lon + 180) * samples_per_degree, (at.lat + 90) * samples_per_degree};
}

TileAt tile_of(double x, double y) {
  return {static_cast<std::int64_t>(std::floor(x / kTile)), static_cast<std::int64_t>(std::floor(y / kTile))};
}

using Surface = std::map<TileAt, std::vector<float>>;

Surface resampled(const Raster& raster, double samples_per_degree, double tolerance) {
  const ProjectedResampler resampler(raster.georeference, raster.window, samples_per_degree);
  Surface tiles;
  for (std::int64_t row = 0; row <= raster.window.y.last; ++row) {
    for (std::int64_t column = 0; column <= raster.window.x.last; ++column) {
      const Place place = place_of(raster, samples_per_degree, column, row);
      tiles.try_emplace(tile_of(place.x, place.y));
    }
  }
  double most_rounds = 0, worst = 0, cubic = 0, seconds = 0;
  for (auto& [tile, samples] : tiles) {
    const IndexWindow window = window_of(tile);
    const SamplePositions positions = resampler.positions_of(window);
    const std::vector<float> posts = complete_posts(raster, positions.posts);
    const std::vector<std::uint8_t> fitted = posts_of(raster, positions.posts);
    samples.resize(static_cast<std::size_t>(window.count()));
    cubic = std::max(
        cubic, resampler.resample(posts, fitted, {}, positions, {0, 1e9}, samples, {}).worst_residual_m);
    const double start = thread_seconds();
    const auto fit = resampler.resample(posts, fitted, {}, positions, {0, tolerance}, samples, {});
    seconds += thread_seconds() - start;
    most_rounds = std::max(most_rounds, static_cast<double>(fit.rounds));
    worst = std::max(worst, fit.worst_residual_m);
  }
  fmt::print(
      "  {} tiles: at most {} rounds, residual {:.4f} m (cubic alone {:.2f} m), {:.1f} ms CPU a tile\n",
      tiles.size(), most_rounds, worst, cubic, 1e3 * seconds / static_cast<double>(tiles.size()));
  return tiles;
}

void compare_edges(const Surface& surface) {
  double worst = 0;
  for (const auto& [tile, samples] : surface) {
    for (const TileAt next : {TileAt{tile.x + 1, tile.y}, TileAt{tile.x, tile.y + 1}}) {
      const auto found = surface.find(next);
      if (found == surface.end()) continue;
      for (std::int64_t k = 0; k <= kTile; ++k) {
        const bool east = next.x > tile.x;
        const std::int64_t x = east ? next.x * kTile : tile.x * kTile + k;
        const std::int64_t y = east ? tile.y * kTile + k : next.y * kTile;
        worst = std::max(worst, std::abs(static_cast<double>(samples[window_of(tile).offset(x, y)] -
                                                             found->second[window_of(next).offset(x, y)])));
      }
    }
  }
  fmt::print("  neighbours differ on their common edge by at most {:.4f} m\n", worst);
}

void check_posts(const Raster& raster, const Surface& surface, double samples_per_degree) {
  double worst = 0, squares = 0, count = 0;
  const auto sample = [&surface](double x, double y) {  // an edge is that of the tile east or north
    const auto tile = surface.find(tile_of(x, y));
    if (tile == surface.end()) return std::numeric_limits<double>::quiet_NaN();
    const std::size_t at =
        window_of(tile->first).offset(static_cast<std::int64_t>(x), static_cast<std::int64_t>(y));
    return static_cast<double>(tile->second[at]);
  };
  for (std::int64_t row = 0; row <= raster.window.y.last; ++row) {
    for (std::int64_t column = 0; column <= raster.window.x.last; ++column) {
      const Place place = place_of(raster, samples_per_degree, column, row);
      const double i = std::floor(place.x), j = std::floor(place.y), s = place.x - i, t = place.y - j;
      const double height = (1 - t) * ((1 - s) * sample(i, j) + s * sample(i + 1, j)) +
                            t * ((1 - s) * sample(i, j + 1) + s * sample(i + 1, j + 1));
      const double error =
          std::abs(height - static_cast<double>(raster.heights[raster.window.offset(column, row)]));
      if (std::isnan(error)) continue;
      worst = std::max(worst, error);
      squares += error * error;
      ++count;
    }
  }
  fmt::print("  put together: {} posts, rms error {:.5f} m, at most {:.4f} m\n", count,
             std::sqrt(squares / count), worst);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const double samples_per_degree = std::atof(argv[1]);
  const double tolerance = std::atof(argv[2]);
  const auto raster = read(argv[3]);
  if (!raster) {
    fmt::print(stderr, "{}\n", raster.error().message);
    return static_cast<int>(raster.error().code);
  }
  const std::string path = argv[3];
  fmt::print("{}: {:.0f} posts a degree to {:.0f} samples, tolerance {} m\n",
             path.substr(path.rfind('/') + 1), posts_per_degree(raster->georeference, raster->window),
             samples_per_degree, tolerance);
  const Surface surface = resampled(*raster, samples_per_degree, tolerance);
  compare_edges(surface);
  check_posts(*raster, surface, samples_per_degree);
  return 0;
}
