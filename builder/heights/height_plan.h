#pragma once

#include "builder/bake/tile_tree.h"
#include "builder/heights/geometric_error.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/grid_options.h"
#include "cairn/height_options.h"
#include "cairn/tile_id.h"

namespace cairn {

/// What the heights layer of a bake will be, decided before any post is read.
class HeightPlan {
 public:
  /// REQUIRES: the mosaic outlives the plan.
  static Result<HeightPlan> make(const Mosaic& mosaic, const MosaicOptions& asked,
                                 const HeightOptions& heights, const GridOptions& grid);

  int tile_size() const { return tile_size_; }
  int top() const { return tree_.top(); }  ///< the coarsest level
  int finest() const { return finest_; }   ///< the finest level that is stored
  /// E: what posts of a group of the mosaic may be off by; and the largest and the least of all groups.
  double error_bound_m(std::size_t group) const { return mosaic_->error_bound_m(group); }
  double error_bound_m() const { return error_bounds_.largest_m; }
  double least_error_bound_m() const { return error_bounds_.least_m; }

  double quantum_m() const { return quantum_m_; }
  /// In quanta: to what multiples samples are rounded that posts of whole metres alone decide
  /// (Mosaic::near_fractions()). 1 where no other posts are.
  int whole_metre_step() const { return whole_metre_step_; }

  /// What is left of a group's error bound for the surface before it is rounded.
  SmoothTolerance tolerance(std::size_t group) const;
  /// Tells every group of the mosaic that the plan was made for its tolerance().
  void set_tolerances(Mosaic& mosaic) const;

  /// The tiles, before pruning leaves any out.
  const TileTree& tree() const { return tree_; }
  /// Which posts of a leaf are its own to count.
  PostCounting counting(const TileId& leaf) const;

 private:
  explicit HeightPlan(const Mosaic& mosaic);
  Status choose_levels(const MosaicOptions& asked, const GridOptions& grid);
  double step_of_whole_metres(ResampleMethod resampling) const;
  void choose_quantum(const MosaicOptions& asked, const HeightOptions& heights);

  const Mosaic* mosaic_;
  Mosaic::ErrorBounds error_bounds_;
  int tile_size_ = 513;
  int finest_ = 0;
  double quantum_m_ = 0.25;
  int whole_metre_step_ = 1;
  TileTree tree_;
};

}  // namespace cairn
