#include "builder/export/grid_sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include <tbb/parallel_for.h>

#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

constexpr std::size_t kMostPieces = 64;
constexpr std::size_t kLeastColumns = 256;  // of a piece
constexpr std::size_t kTilesAtLeast = 8;    // kept by each piece: those of a row of tiles and their ancestors

}  // namespace

struct GridSampler::State {
  Status fill_piece(std::size_t piece, int first, std::size_t rows, std::span<float> out);

  GeoGrid posts;
  int level = 0;
  std::size_t piece_columns = 0;
  std::vector<PackSampler> samplers;  // one for each piece of the columns, which one thread fills at a time
};

Status GridSampler::State::fill_piece(std::size_t piece, int first, std::size_t rows, std::span<float> out) {
  const auto columns = static_cast<std::size_t>(posts.columns);
  const std::size_t begin = piece * piece_columns, end = std::min(columns, begin + piece_columns);
  for (std::size_t r = 0; r < rows; ++r) {
    const double row = first + static_cast<double>(r);
    const double lat = std::clamp(posts.north - row * posts.row_degrees, -90.0, 90.0);
    for (std::size_t c = begin; c < end; ++c) {
      const double lon = posts.west + static_cast<double>(c) * posts.column_degrees;
      const auto height = samplers[piece].height_at({lon, lat}, level);
      if (!height) return height.error();
      out[r * columns + c] =
          *height ? static_cast<float>((*height)->metres) : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return {};
}

GridSampler::GridSampler(const PackReader& pack, const GeoGrid& posts, int level)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.posts = posts;
  s.level = level;
  const auto columns = static_cast<std::size_t>(posts.columns);
  s.piece_columns = std::max(kLeastColumns, (columns + kMostPieces - 1) / kMostPieces);
  const double degrees = static_cast<double>(s.piece_columns) * posts.column_degrees;
  const auto across = static_cast<std::size_t>(std::ldexp(degrees, level)) + 2;
  const std::size_t tiles = std::clamp<std::size_t>(2 * across, kTilesAtLeast, 64);
  for (std::size_t c = 0; c < columns; c += s.piece_columns) s.samplers.emplace_back(pack, tiles);
}

GridSampler::~GridSampler() = default;
GridSampler::GridSampler(GridSampler&&) noexcept = default;

Status GridSampler::fill(int first, std::span<float> out) {
  const std::size_t rows = out.size() / static_cast<std::size_t>(state_->posts.columns);
  std::vector<Status> statuses(state_->samplers.size());
  tbb::parallel_for(std::size_t{0}, statuses.size(), [&](std::size_t piece) {
    statuses[piece] = state_->fill_piece(piece, first, rows, out);
  });
  const auto bad = std::find_if(statuses.begin(), statuses.end(), [](const Status& s) { return !s.ok(); });
  return bad == statuses.end() ? Status() : *bad;
}

}  // namespace cairn
