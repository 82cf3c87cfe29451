#pragma once

#include <memory>
#include <span>

#include "builder/export/tiff_writer.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Heights of a pack on a regular grid, band by band of rows, sampled by all threads of the caller's arena.
/// The tiles of a level are used, and where it has none, or they were left out, the nearest coarser ones.
class GridSampler {
 public:
  /// Rows that are best asked for at a time.
  static constexpr int kBandRows = 64;

  /// `posts` has the places of the first post and the steps; latitudes past a pole count as the pole.
  /// REQUIRES: the reader outlives the sampler.
  GridSampler(const PackReader& pack, const GeoGrid& posts, int level);
  ~GridSampler();
  GridSampler(GridSampler&&) noexcept;

  /// Fills rows from `first` on, row-major, from the north: metres, a void NaN. REQUIRES: out.size() is
  /// posts.columns times a number of rows.
  Status fill(int first, std::span<float> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cairn
