#include "builder/python/pack.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

namespace cairn {
namespace {

constexpr std::size_t kCachedTiles = 32;  // of a sampler: 1 MiB each

/// The places' indices, those of one tile one after the other. Places that are none come first.
std::vector<std::uint32_t> by_tile(std::span<const double> lon, std::span<const double> lat, int level) {
  std::unordered_map<TileId, std::uint32_t> groups;
  std::vector<std::uint32_t> group_of(lon.size(), 0), counts{0};
  GeoBounds last{0, 0, -1, -1};  // of the tile that the last place was in
  std::uint32_t last_group = 0;
  for (std::size_t i = 0; i < lon.size(); ++i) {
    if (lon[i] >= last.west && lon[i] < last.east && lat[i] >= last.south && lat[i] < last.north) {
      group_of[i] = last_group;
    } else if (std::isfinite(lon[i]) && std::abs(lat[i]) <= 90) {
      const TileId id = tile_at({lon[i], lat[i]}, level);
      const auto [at, is_new] = groups.try_emplace(id, static_cast<std::uint32_t>(counts.size()));
      if (is_new) counts.push_back(0);
      last = tile_bounds(id);
      group_of[i] = last_group = at->second;
    }
    ++counts[group_of[i]];
  }
  std::uint32_t begin = 0;
  for (std::uint32_t& count : counts) begin += std::exchange(count, begin);
  std::vector<std::uint32_t> order(lon.size());
  for (std::size_t i = 0; i < lon.size(); ++i) order[counts[group_of[i]]++] = static_cast<std::uint32_t>(i);
  return order;
}

/// Calls draw(row, column) for every pixel, square by square, so that few tiles are in use at a time.
template <class Draw>
Status for_each_pixel(const Window& window, const Draw& draw) {
  constexpr std::size_t kSquare = 256;
  for (std::size_t top = 0; top < window.rows; top += kSquare) {
    for (std::size_t left = 0; left < window.columns; left += kSquare) {
      for (std::size_t row = top; row < std::min(window.rows, top + kSquare); ++row) {
        for (std::size_t column = left; column < std::min(window.columns, left + kSquare); ++column)
          if (Status status = draw(row, column); !status) return status;
      }
    }
  }
  return {};
}

Status answer(PackSampler& sampler, LonLat place, std::optional<int> level, std::size_t i,
              HeightAnswers& out) {
  const auto height = level ? sampler.height_at(place, *level, *level) : sampler.height_at(place);
  if (!height) return height.error();
  const bool there = height->has_value();
  out.metres[i] = there ? (*height)->metres : std::numeric_limits<double>::quiet_NaN();
  out.levels[i] = there ? static_cast<std::int8_t>((*height)->level) : kNoLevel;
  out.errors_m[i] = there ? (*height)->error_m : std::numeric_limits<float>::quiet_NaN();
  return {};
}

}  // namespace

Result<std::unique_ptr<Pack>> Pack::open(const std::filesystem::path& path) {
  auto reader = PackReader::open(path);
  if (!reader) return reader.error();
  return std::unique_ptr<Pack>(new Pack(*std::move(reader)));
}

/// A sampler belongs to one call at a time.
template <class Sampler, class Work>
Status Pack::with_sampler(Pool<Sampler>& pool, const Work& work) const {
  std::unique_ptr<Sampler> sampler;
  {
    const std::lock_guard lock(mutex_);
    if (!pool.idle.empty()) {
      sampler = std::move(pool.idle.back());
      pool.idle.pop_back();
    }
  }
  if (!sampler) sampler = std::make_unique<Sampler>(reader_, kCachedTiles);
  Status status = work(*sampler);
  const std::lock_guard lock(mutex_);
  pool.idle.push_back(std::move(sampler));
  return status;
}

Status Pack::heights(std::span<const double> lon, std::span<const double> lat, std::optional<int> level,
                     HeightAnswers out) const {
  assert(lon.size() == lat.size() && lon.size() == out.metres.size());
  const auto range = reader_.levels(Layer::heights);
  const int finest = range ? range->finest : 0;
  constexpr std::size_t kMostAtATime = std::size_t{1} << 24;
  return with_sampler(height_samplers_, [&](PackSampler& sampler) -> Status {
    for (std::size_t first = 0; first < lon.size(); first += kMostAtATime) {
      const std::size_t count = std::min(kMostAtATime, lon.size() - first);
      for (const std::uint32_t at : by_tile(lon.subspan(first, count), lat.subspan(first, count), finest)) {
        const std::size_t i = first + at;
        if (auto status = answer(sampler, {lon[i], lat[i]}, level, i, out); !status) return status;
      }
    }
    return {};
  });
}

Status Pack::draw_heights(const Window& window, int level, std::span<double> metres) const {
  return with_sampler(height_samplers_, [&](PackSampler& sampler) -> Status {
    return for_each_pixel(window, [&](std::size_t row, std::size_t column) -> Status {
      const auto height = sampler.height_at(window.centre(row, column), level);
      if (!height) return height.error();
      metres[row * window.columns + column] =
          *height ? (*height)->metres : std::numeric_limits<double>::quiet_NaN();
      return {};
    });
  });
}

Status Pack::draw_imagery(const Window& window, int level, std::span<std::uint8_t> rgba) const {
  return with_sampler(imagery_samplers_, [&](ImagerySampler& sampler) -> Status {
    return for_each_pixel(window, [&](std::size_t row, std::size_t column) -> Status {
      const auto colour = sampler.colour_at(window.centre(row, column), level);
      if (!colour) return colour.error();
      std::copy(colour->begin(), colour->end(), rgba.data() + (row * window.columns + column) * 4);
      return {};
    });
  });
}

int Pack::level_for(const Window& window, Layer layer) const {
  constexpr double kNearly = 1e-9;
  const auto range = *reader_.levels(layer);
  const double pixel = std::min(window.bounds.width() / static_cast<double>(window.columns),
                                window.bounds.height() / static_cast<double>(window.rows));
  int level = range.coarsest;
  while (level < range.finest &&
         tile_width_degrees(level) / (reader_.header().tile_size - 1) > pixel * (1 + kNearly))
    ++level;
  return level;
}

}  // namespace cairn
