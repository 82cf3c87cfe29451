// usage: cairn-resample-bench RASTER...
//
// The CPU time of a tile, then how well resampled surfaces meet posts that they have not seen: each raster
// (geographic, its voids filled) is thinned, resampled from what is left, and compared with the rest.

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "builder/raster/raster_source.h"
#include "builder/resample/resample_lattice.h"
#include "builder/voids/void_fill.h"

namespace {

using namespace cairn;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Field {
  IndexWindow window;
  std::vector<float> heights;

  double at(std::int64_t x, std::int64_t y) const {
    return static_cast<double>(heights[window.offset(x, y)]);
  }
};

Field filled(const Field& raster) {
  FillPyramidBuilder builder(raster.window);
  builder.add(raster.window, raster.heights);
  const IndexWindow around = posts_to_fill(raster.window);
  std::vector<float> posts(static_cast<std::size_t>(around.count()), std::numeric_limits<float>::quiet_NaN());
  for (std::int64_t y = raster.window.y.first; y <= raster.window.y.last; ++y) {
    const float* row = &raster.heights[raster.window.offset(raster.window.x.first, y)];
    std::copy_n(row, raster.window.x.count(), &posts[around.offset(raster.window.x.first, y)]);
  }
  Field out = raster;
  fill_voids(builder.complete(), posts, raster.window, out.heights);
  return out;
}

Field thinned(const Field& from, std::int64_t by) {
  Field out{{{0, from.window.x.last / by}, {0, from.window.y.last / by}}, {}};
  for (std::int64_t y = 0; y <= out.window.y.last; ++y) {
    for (std::int64_t x = 0; x <= out.window.x.last; ++x) {
      out.heights.push_back(static_cast<float>(from.at(x * by, y * by)));
    }
  }
  return out;
}

// The linear interpolant's samples and fractions for the raster's posts, of which every by-th was kept.
struct Place {
  std::int64_t sample = 0;
  double fraction = 0;
};

std::vector<Place> places(std::int64_t posts, double samples_a_post) {
  std::vector<Place> all;
  for (std::int64_t i = 0; i < posts; ++i) {
    const double x = static_cast<double>(i) * samples_a_post;
    const double below = std::floor(x + 1e-9);
    all.push_back({static_cast<std::int64_t>(below), std::max(0.0, x - below)});
  }
  return all;
}

double surface(const Field& samples, Place x, Place y) {
  const double south =
      (1 - x.fraction) * samples.at(x.sample, y.sample) + x.fraction * samples.at(x.sample + 1, y.sample);
  const double north = (1 - x.fraction) * samples.at(x.sample, y.sample + 1) +
                       x.fraction * samples.at(x.sample + 1, y.sample + 1);
  return (1 - y.fraction) * south + y.fraction * north;
}

struct Errors {
  double squares = 0;
  double worst = 0;
  std::int64_t count = 0;

  void add(double error) {
    squares += error * error;
    worst = std::max(worst, std::abs(error));
    ++count;
  }
  double rms() const { return std::sqrt(squares / static_cast<double>(std::max<std::int64_t>(count, 1))); }
};

// The mean square of the samples' second differences: what of the surface's roughness is the method's.
double roughness(const Field& samples) {
  Errors bends;
  for (std::int64_t y = samples.window.y.first; y <= samples.window.y.last; ++y) {
    for (std::int64_t x = samples.window.x.first + 1; x < samples.window.x.last; ++x) {
      bends.add(samples.at(x - 1, y) - 2 * samples.at(x, y) + samples.at(x + 1, y));
    }
  }
  return bends.rms();
}

constexpr std::int64_t kMargin = 40;  // kept posts at the edges that the samples' reach needs

struct Trial {
  const Field& raster;  // voids NaN
  const Field& complete;
  std::int64_t by;
  double kept_per_degree;
  double samples_per_degree;
};

Field resampled(const AxisResampler& axis, const Field& kept, double ratio, double& seconds) {
  const auto range = [ratio](IndexRange posts) {
    return IndexRange{
        static_cast<std::int64_t>(std::ceil(static_cast<double>(kMargin) * ratio)),
        static_cast<std::int64_t>(std::floor(static_cast<double>(posts.last - kMargin) * ratio))};
  };
  Field samples{{range(kept.window.x), range(kept.window.y)}, {}};
  samples.heights.resize(static_cast<std::size_t>(samples.window.count()));
  seconds = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 5; ++run) {
    const double start = thread_seconds();
    resample_lattice(axis, axis, kept.window, kept.heights, samples.window, samples.heights);
    seconds = std::min(seconds, thread_seconds() - start);
  }
  return samples;
}

void report(const Trial& trial, const Field& kept, ResampleMethod method, const char* name) {
  const AxisResampler axis({trial.kept_per_degree, 0}, trial.samples_per_degree, method);
  const double ratio = trial.samples_per_degree / trial.kept_per_degree;
  double seconds = 0;
  const Field samples = resampled(axis, kept, ratio, seconds);
  const double step = ratio / static_cast<double>(trial.by);
  const std::vector<Place> x = places(trial.raster.window.x.count(), step);
  const std::vector<Place> y = places(trial.raster.window.y.count(), step);
  Errors at_kept, between;
  for (std::size_t j = 0; j < y.size(); ++j) {
    if (!samples.window.y.holds({y[j].sample, y[j].sample + 1})) continue;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!samples.window.x.holds({x[i].sample, x[i].sample + 1})) continue;
      const double post = trial.raster.at(static_cast<std::int64_t>(i), static_cast<std::int64_t>(j));
      if (std::isnan(post)) continue;
      const auto by = static_cast<std::size_t>(trial.by);
      (i % by == 0 && j % by == 0 ? at_kept : between).add(surface(samples, x[i], y[j]) - post);
    }
  }
  fmt::print("  {:9} {:8.3f} {:8.1f} {:9.4f} {:9.4f} {:10.2f} {:9.2f}\n", name, between.rms(), between.worst,
             at_kept.rms(), at_kept.worst, roughness(samples),
             1e9 * seconds / static_cast<double>(samples.window.count()));
}

void try_methods(const Field& raster, const Field& complete, double posts_per_degree, std::int64_t by,
                 double samples_per_degree) {
  const Trial trial{raster, complete, by, posts_per_degree / static_cast<double>(by), samples_per_degree};
  fmt::print(" every {}: {:.0f} posts a degree to {:.0f} samples, {:.4f} samples a post\n", by,
             trial.kept_per_degree, samples_per_degree, samples_per_degree / trial.kept_per_degree);
  fmt::print("  {:9} {:>17} {:>19} {:>10} {:>9}\n", "", "rms, max between m", "rms, max at posts m",
             "bend rms m", "ns/sample");
  const Field kept = thinned(complete, by);
  report(trial, kept, ResampleMethod::nearest, "nearest");
  report(trial, kept, ResampleMethod::bilinear, "bilinear");
  report(trial, kept, ResampleMethod::cubic, "cubic");
  report(trial, kept, ResampleMethod::exact, "exact");
}

Status run(const char* path) {
  auto source = open_raster(path, {});
  if (!source) return source.error();
  const RasterInfo& info = (*source)->info();
  if (info.georeference.crs != Georeference::Crs::geographic) {
    return bad_data(fmt::format("{}: coordinates: expected geographic, found a projection", path));
  }
  Field raster{{{0, info.columns - 1}, {0, info.rows - 1}},
               std::vector<float>(static_cast<std::size_t>(info.columns * info.rows))};
  if (auto status = (*source)->read_heights({0, 0, info.columns, info.rows}, raster.heights); !status)
    return status;
  const Field complete = filled(raster);
  const double posts_per_degree = std::round(1 / info.georeference.dx);
  fmt::print("{}\n", info.path.filename().string());
  for (const std::int64_t by : {2, 3}) {
    double samples_per_degree = 1;
    while (samples_per_degree * static_cast<double>(by) < posts_per_degree) samples_per_degree *= 2;
    try_methods(raster, complete, posts_per_degree, by, samples_per_degree);
  }
  return {};
}

void time_tile(double posts_per_degree, double samples_per_degree) {
  const IndexWindow samples{{100 * 512, 101 * 512}, {70 * 512, 71 * 512}};
  std::vector<float> out(static_cast<std::size_t>(samples.count()));
  fmt::print("{:.0f} posts a degree to {:.0f} samples:", posts_per_degree, samples_per_degree);
  for (const auto method :
       {ResampleMethod::nearest, ResampleMethod::bilinear, ResampleMethod::cubic, ResampleMethod::exact}) {
    const AxisResampler axis({posts_per_degree, 0}, samples_per_degree, method);
    const IndexWindow posts{axis.posts_for(samples.x), axis.posts_for(samples.y)};
    const std::vector<float> heights(static_cast<std::size_t>(posts.count()), 1234.5f);
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < 30; ++run) {
      const double start = thread_seconds();
      resample_lattice(axis, axis, posts, heights, samples, out);
      best = std::min(best, thread_seconds() - start);
    }
    fmt::print(" {:.2f}", 1e3 * best);
  }
  fmt::print(" ms (nearest, bilinear, cubic, exact)\n");
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print("a tile of 513 x 513 samples, best of 30:\n");
  time_tile(1200, 2048);
  time_tile(3600, 4096);
  time_tile(1200, 1280);
  for (int i = 1; i < argc; ++i) {
    if (const auto status = run(argv[i]); !status) {
      fmt::print(stderr, "{}\n", status.error().message);
      return static_cast<int>(status.error().code);
    }
  }
  return argc > 1 ? 0 : 2;
}
