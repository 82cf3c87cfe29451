#pragma once

#include <cstdint>
#include <vector>

#include "builder/resample/index_window.h"

namespace cairn {

/// One level of a pull-push pyramid: heights, and the share of each cell's posts that are valid. Cell c of a
/// level covers cells 2c and 2c+1 of the next finer one, so that the pyramid stands on absolute indices.
struct FillLevel {
  IndexWindow window;
  std::vector<float> heights;
  std::vector<float> valid;  ///< 0 … 1; where 0, the height is to be filled

  /// All void.
  explicit FillLevel(IndexWindow cells);
};

/// Cells that relax()'s result depends on, around a cell.
inline constexpr std::int64_t kRelaxMargin = 4;

IndexWindow grown(IndexWindow cells, std::int64_t by);
/// The finer level's cells that these cover.
IndexWindow covered_by(IndexWindow cells);
/// The coarser level's cells that cover these, and those that push() reads for these.
IndexWindow covering(IndexWindow cells);
IndexWindow pushed_from(IndexWindow cells);

/// Pull: the means of the valid posts, by cells of 2 by 2; what `from` does not hold counts as void.
FillLevel pulled(const FillLevel& from, IndexWindow window);

/// Push: each void cell gets the coarser level's bilinear interpolant; where `coarse` ends, its last cells go
/// on.
void push(const FillLevel& coarse, FillLevel& to);

/// Relaxes the void cells towards the mean of their four neighbours (Laplace's equation, valid cells being
/// its boundary) by red-black Gauss-Seidel sweeps. Where the window ends, its last cells go on.
void relax(FillLevel& level);

}  // namespace cairn
