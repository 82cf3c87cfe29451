#include "builder/mosaic/companions.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>

#include <fmt/format.h>

namespace cairn {
namespace {

// Endings of names, in lower case: ArcticDEM and REMA, ASTER GDEM, Copernicus DEM and TanDEM-X, ALOS World
// 3D, NASADEM, USGS 3DEP.
constexpr std::array<std::string_view, 32> kEndings = {
    "count", "mad", "num",  "datamask", "matchtag", "bitmask", "mindate", "maxdate",
    "edm",   "flm", "hem",  "wbm",      "acm",      "wam",     "cov",     "com",
    "lsm",   "amp", "am2",  "inc",      "qa",       "quality", "mask",    "msk",
    "stk",   "swb", "swbd", "err",      "error",    "weight",  "source",  "coverage"};

constexpr std::size_t kFewValues = 32;  // of a companion's posts: fewer than a DEM has, unless it is flat
constexpr double kSmallValue = 255;     // and none beyond this
constexpr std::int64_t kPostsInRow = 512;
constexpr std::int64_t kRowsLookedAt = 16;

std::string ending_of(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t at = stem.find_last_of("_-.");
  std::string ending = at == std::string::npos ? "" : stem.substr(at + 1);
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_companion_by_name(const std::filesystem::path& path) {
  return std::find(kEndings.begin(), kEndings.end(), ending_of(path)) != kEndings.end();
}

struct Values {
  std::set<float> distinct;  // up to one more than few
  bool small_and_whole = true;

  bool few() const { return distinct.size() <= kFewValues; }
};

// Of rows spread over the raster.
Result<Values> values_of(RasterPool& pool, std::size_t source) {
  const RasterInfo& info = pool.info(source);
  const auto raster = pool.acquire(source);
  if (!raster) return raster.error();
  Values values;
  const std::int64_t columns = std::min(info.columns, kPostsInRow);
  std::vector<float> row(static_cast<std::size_t>(columns));
  for (std::int64_t i = 0; i < kRowsLookedAt; ++i) {
    const std::int64_t r = i * (info.rows - 1) / (kRowsLookedAt - 1);
    const std::int64_t c = i * (info.columns - columns) / (kRowsLookedAt - 1);
    if (auto read = (*raster)->read_heights({c, r, columns, 1}, row); !read) return read.error();
    for (const float h : row) {
      if (std::isnan(h)) continue;
      if (values.few()) values.distinct.insert(h);
      values.small_and_whole =
          values.small_and_whole && h >= 0 && static_cast<double>(h) <= kSmallValue && h == std::floor(h);
    }
  }
  return values;
}

// Whether the posts of `source` are marks beside those of `dem`.
Result<bool> is_companion_by_values(RasterPool& pool, std::size_t source, std::size_t dem) {
  const auto own = values_of(pool, source);
  if (!own) return own.error();
  if (!own->few() || !own->small_and_whole) return false;
  const auto other = values_of(pool, dem);
  if (!other) return other.error();
  return !other->few();
}

struct Companion {
  std::size_t source = 0;
  std::size_t dem = 0;
  const char* how = "";
};

// Among sources of one grid.
Result<std::vector<Companion>> companions_among(RasterPool& pool, const std::vector<std::size_t>& sources) {
  std::vector<std::size_t> named, others;
  for (const std::size_t s : sources) (is_companion_by_name(pool.info(s).path) ? named : others).push_back(s);
  std::vector<Companion> found;
  if (others.empty()) return found;
  for (const std::size_t s : named) found.push_back({s, others.front(), "by its name"});
  for (const std::size_t s : others) {
    for (const std::size_t dem : others) {
      if (s == dem) continue;
      const auto is = is_companion_by_values(pool, s, dem);
      if (!is) return is.error();
      if (!*is) continue;
      found.push_back({s, dem, "by its few small whole numbers"});
      break;
    }
  }
  return found;
}

}  // namespace

Status refuse_companions(RasterPool& pool) {
  using Grid = std::tuple<std::int64_t, std::int64_t, double, double, double, double>;
  std::map<Grid, std::vector<std::size_t>> by_grid;
  for (std::size_t s = 0; s < pool.size(); ++s) {
    const RasterInfo& info = pool.info(s);
    by_grid[{info.columns, info.rows, info.bounds.west, info.bounds.south, info.bounds.east,
             info.bounds.north}]
        .push_back(s);
  }
  std::string list;
  std::size_t count = 0;
  for (const auto& [grid, sources] : by_grid) {
    if (sources.size() < 2) continue;
    const auto companions = companions_among(pool, sources);
    if (!companions) return companions.error();
    for (const Companion& c : *companions) {
      list += fmt::format("{}{} ({}, beside {})", count++ == 0 ? "" : ", ", pool.info(c.source).path.string(),
                          c.how, pool.info(c.dem).path.filename().string());
    }
  }
  if (count == 0) return {};
  return bad_data(fmt::format(
      "heights: expected DEMs, found {} raster{} of another kind on a DEM's grid, to be left out: {}", count,
      count == 1 ? "" : "s", list));
}

}  // namespace cairn
