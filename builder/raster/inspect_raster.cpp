#include "builder/raster/inspect_raster.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace cairn {
namespace {

constexpr std::int64_t kBandRows = 64;
constexpr std::size_t kMostPlaces = 10;
constexpr double kLeastSpike = 20;  // metres
constexpr double kLeastStep = 0.5;  // metres
constexpr double kStepFactor = 10;  // above the median of all lines
constexpr double kSpikeFactor = 5;  // above what 99 % of the posts have
constexpr std::size_t kBins = 4096;
constexpr double kBinMetres = 0.25;

/// Sums over one line between two columns or rows.
struct LineSum {
  double jump = 0;
  std::uint64_t posts = 0;
  std::uint64_t upwards = 0;  ///< posts whose jump is above 0
  double mean() const { return posts > 0 ? jump / static_cast<double>(posts) : 0; }
  /// Whether most posts jump one way: a single spike or a lake's edge moves the mean, but not most posts.
  bool is_shared() const { return 4 * std::max(upwards, posts - upwards) >= 3 * posts; }
};

/// Rows of a raster with those before and after them: rows first-1 to first+rows.
struct Band {
  std::int64_t columns = 0;
  std::int64_t first = 0;
  std::int64_t rows = 0;
  std::int64_t read_from = 0;
  std::vector<float> metres;

  float at(std::int64_t column, std::int64_t row) const {
    return metres[static_cast<std::size_t>((row - read_from) * columns + column)];
  }
};

Result<Band> read_band(const RasterSource& source, std::int64_t first) {
  const RasterInfo& info = source.info();
  Band band{
      info.columns, first, std::min(kBandRows, info.rows - first), std::max<std::int64_t>(0, first - 1), {}};
  // Two more below, for the slope beyond the line under the last row.
  const std::int64_t end = std::min(info.rows, first + band.rows + 2);
  band.metres.resize(static_cast<std::size_t>((end - band.read_from) * info.columns));
  const Status read =
      source.read_heights({0, band.read_from, info.columns, end - band.read_from}, band.metres);
  if (!read) return read.error();
  return band;
}

class Inspection {
 public:
  explicit Inspection(const RasterInfo& info)
      : info_(info),
        column_lines_(static_cast<std::size_t>(info.columns)),
        row_lines_(static_cast<std::size_t>(info.rows)),
        roughness_(kBins) {}

  void add(const Band& band) {
    for (std::int64_t row = band.first; row < band.first + band.rows; ++row)
      for (std::int64_t column = 0; column < info_.columns; ++column) add_post(band, column, row);
  }

  RasterFindings finish() {
    drop_usual_spikes();
    std::sort(found_.highest_spikes.begin(), found_.highest_spikes.end(),
              [](const OddPlace& a, const OddPlace& b) { return std::abs(a.metres) > std::abs(b.metres); });
    if (found_.highest_spikes.size() > kMostPlaces) found_.highest_spikes.resize(kMostPlaces);
    add_steps(column_lines_, true);
    add_steps(row_lines_, false);
    std::sort(found_.steps.begin(), found_.steps.end(), [](const HeightStep& a, const HeightStep& b) {
      return std::abs(a.metres) > std::abs(b.metres);
    });
    if (found_.steps.size() > kMostPlaces) found_.steps.resize(kMostPlaces);
    std::uint64_t most = 0;
    for (const auto& [metres, posts] : level_)
      if (posts > most) most = posts, found_.level_m = static_cast<double>(metres);
    return std::move(found_);
  }

 private:
  void add_post(const Band& band, std::int64_t column, std::int64_t row) {
    const float height = band.at(column, row);
    ++found_.posts;
    if (std::isnan(height)) {
      ++found_.voids;
      return;
    }
    const double h = static_cast<double>(height);
    found_.lowest_m = found_.posts - found_.voids == 1 ? h : std::min(found_.lowest_m, h);
    found_.highest_m = found_.posts - found_.voids == 1 ? h : std::max(found_.highest_m, h);
    found_.only_whole_metres = found_.only_whole_metres && std::floor(h) == h;
    const bool east = column + 1 < info_.columns, south = row + 1 < info_.rows;
    if (east && south && band.at(column + 1, row) == height && band.at(column, row + 1) == height) {
      ++found_.level_posts;
      if (level_.size() < kBins || level_.contains(height)) ++level_[height];
    }
    if (column > 0 && column + 2 < info_.columns)
      add_line(column_lines_[static_cast<std::size_t>(column)], band.at(column - 1, row), h,
               band.at(column + 1, row), band.at(column + 2, row));
    if (row > 0 && row + 2 < info_.rows)
      add_line(row_lines_[static_cast<std::size_t>(row)], band.at(column, row - 1), h,
               band.at(column, row + 1), band.at(column, row + 2));
    if (column > 0 && east && row > 0 && south) add_neighbours(band, column, row, h);
  }

  /// The jump from `here` to `next` beyond the mean of the slopes before and after.
  static void add_line(LineSum& line, float before, double here, float next, float after) {
    if (std::isnan(before) || std::isnan(next) || std::isnan(after)) return;
    const double b = static_cast<double>(before), n = static_cast<double>(next),
                 a = static_cast<double>(after);
    const double jump = (n - here) - ((here - b) + (a - n)) / 2;
    line.jump += jump;
    line.upwards += jump > 0 ? 1 : 0;
    ++line.posts;
  }

  void add_neighbours(const Band& band, std::int64_t column, std::int64_t row, double h) {
    double sum = 0, least = INFINITY;
    bool above = true, below = true;
    for (const auto& [dc, dr] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const double n = static_cast<double>(band.at(column + dc, row + dr));
      if (std::isnan(n)) return;
      sum += n;
      above = above && h > n;
      below = below && h < n;
      least = std::min(least, std::abs(h - n));
    }
    const double difference = h - sum / 4;
    const auto bin = static_cast<std::size_t>(std::abs(difference) / kBinMetres);
    ++roughness_[std::min(bin, kBins - 1)];
    if ((above || below) && least > kLeastSpike)
      candidates_.push_back({column, row, {}, std::copysign(least, difference)});
  }

  void drop_usual_spikes() {
    std::uint64_t all = 0, sum = 0;
    for (const std::uint64_t posts : roughness_) all += posts;
    std::size_t bin = 0;
    while (bin + 1 < kBins && (sum += roughness_[bin]) < all - all / 100) ++bin;
    const double usual = static_cast<double>(bin + 1) * kBinMetres;
    for (OddPlace& candidate : candidates_) {
      if (std::abs(candidate.metres) <= kSpikeFactor * usual) continue;
      ++found_.spikes;
      candidate.place = info_.georeference.place_of(static_cast<double>(candidate.column),
                                                    static_cast<double>(candidate.row));
      found_.highest_spikes.push_back(candidate);
    }
  }

  void add_steps(const std::vector<LineSum>& lines, bool between_columns) {
    std::vector<double> jumps;
    for (const LineSum& line : lines)
      if (line.posts > 0) jumps.push_back(std::abs(line.mean()));
    if (jumps.empty()) return;
    const auto middle = jumps.begin() + static_cast<std::ptrdiff_t>(jumps.size() / 2);
    std::nth_element(jumps.begin(), middle, jumps.end());
    const double least = std::max(kLeastStep, kStepFactor * *middle);
    // Beside a step of a height its neighbours' slopes show half of it, the other way round.
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (lines[i].posts > 0 && std::abs(lines[i].mean()) > least && lines[i].is_shared() &&
          is_peak(lines, i))
        found_.steps.push_back({between_columns, static_cast<std::int64_t>(i), lines[i].mean()});
  }

  static bool is_peak(const std::vector<LineSum>& lines, std::size_t i) {
    const double own = std::abs(lines[i].mean());
    return (i == 0 || own >= std::abs(lines[i - 1].mean())) &&
           (i + 1 == lines.size() || own >= std::abs(lines[i + 1].mean()));
  }

  const RasterInfo& info_;
  RasterFindings found_;
  std::vector<LineSum> column_lines_;  // behind each column
  std::vector<LineSum> row_lines_;     // below each row
  std::vector<std::uint64_t> roughness_;
  std::map<float, std::uint64_t> level_;
  std::vector<OddPlace> candidates_;
};

/// A distance in steps of a grid, and whether it is a whole number of them.
struct GridStep {
  std::int64_t whole = 0;
  bool fits = false;
};

GridStep steps_between(double from, double to, double spacing) {
  constexpr double kNearly = 0.01;
  const double steps = (to - from) / spacing;
  return {std::llround(steps), std::abs(steps - std::round(steps)) < kNearly};
}

}  // namespace

Result<RasterFindings> inspect_raster(const RasterSource& source) {
  Inspection inspection(source.info());
  for (std::int64_t first = 0; first < source.info().rows; first += kBandRows) {
    const auto band = read_band(source, first);
    if (!band) return band.error();
    inspection.add(*band);
  }
  return inspection.finish();
}

Result<Seam> compare_rasters(const RasterSource& first, const RasterSource& second) {
  const RasterInfo &a = first.info(), &b = second.info();
  Seam seam;
  // The first posts and the steps, as places: so any raster whose columns and rows follow the degrees will
  // do.
  const auto corner = [](const RasterInfo& info, double c, double r) {
    return info.georeference.place_of(c, r);
  };
  const LonLat a0 = corner(a, 0, 0), a1 = corner(a, 1, 1), b0 = corner(b, 0, 0), b1 = corner(b, 1, 1);
  const double dx = a1.lon - a0.lon, dy = a1.lat - a0.lat;
  if (std::abs(b1.lon - b0.lon - dx) > 1e-6 * std::abs(dx) ||
      std::abs(b1.lat - b0.lat - dy) > 1e-6 * std::abs(dy))
    return seam;
  const GridStep x = steps_between(a0.lon, b0.lon, dx), y = steps_between(a0.lat, b0.lat, dy);
  if (!x.fits || !y.fits) return seam;
  const std::int64_t c0 = std::max<std::int64_t>(0, x.whole), c1 = std::min(a.columns, x.whole + b.columns);
  const std::int64_t r0 = std::max<std::int64_t>(0, y.whole), r1 = std::min(a.rows, y.whole + b.rows);
  if (c1 <= c0 || r1 <= r0) return seam;
  std::vector<float> one(static_cast<std::size_t>(c1 - c0)), other(one.size());
  double sum = 0;
  for (std::int64_t r = r0; r < r1; ++r) {
    if (auto read = first.read_heights({c0, r, c1 - c0, 1}, one); !read) return read.error();
    if (auto read = second.read_heights({c0 - x.whole, r - y.whole, c1 - c0, 1}, other); !read)
      return read.error();
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (std::isnan(one[i]) || std::isnan(other[i])) continue;
      const double difference = static_cast<double>(other[i]) - static_cast<double>(one[i]);
      ++seam.posts;
      sum += difference;
      seam.max_m = std::max(seam.max_m, std::abs(difference));
    }
  }
  if (seam.posts > 0) seam.mean_m = sum / static_cast<double>(seam.posts);
  return seam;
}

}  // namespace cairn
